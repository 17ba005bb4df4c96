//! Lanes: phase and gain of each, composed of one cosine and one sine.
//!
//! Lanes 0 and 2 are opposites of each other, and so are lanes 1 and 3, which lead them by the
//! quadrature. A quarter turn gives the four phases of a travelling-wave motor (sine, cosine,
//! -sine, -cosine), minus a quarter reverses it, and zero gives a standing wave.
//!
//! ```text
//! offset(lane) = (0, quadrature, 1/2, 1/2 + quadrature) + trim(lane, f)
//! sin(theta + offset) = sin(theta) cos(offset) + cos(theta) sin(offset)
//! ```
//!
//! Therefore the lanes of a sine are the rows of a matrix times one pair a sample. Opposite lanes
//! with the same trim are opposite to the last bit, and one is written from the other.

use heapless::Vec;

use crate::generate::shape::sine;
use crate::seam::block::MAX_LANES;
use crate::seam::config::{Config, Direction, LaneTrims, Phasing as PhasingConfig, Trim};
use crate::seam::error::Error;
use crate::seam::phasor::Phasor;
use crate::seam::units::Turns;

/// Largest quadrature, turns: beyond a quarter turn a motor would change its direction again.
pub(crate) const MAX_QUADRATURE: f32 = 0.25;
/// Offset of each lane: turns, and multiples of the quadrature.
const OFFSETS: [(f32, f32); MAX_LANES] = [(0.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.5, 1.0)];
/// Largest plausible error of a lane: phase in turns, and gain as a factor to either side.
pub(crate) const PLAUSIBLE: (f32, f32) = (0.125, core::f32::consts::SQRT_2);
/// Number of blocks that the multiplexer of the sense channels may take to switch lanes.
pub(crate) const SWITCH_BLOCKS: u32 = 4;
/// Relative change of the frequency after which trims are looked up again.
const RETRIM_REL: f32 = 1e-4;

/// One lane, ready to be applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lane {
    /// Phase offset, 2^32 a turn.
    pub offset: u32,
    /// Gain of the lane.
    pub gain: f32,
    /// Gain in the direction of the offset.
    pub row: Phasor,
    /// `true` if this lane is the opposite of the lane two places before, to the last bit.
    pub(crate) mirrors: bool,
}

/// The lanes of a drive.
#[derive(Clone, Debug)]
pub struct Phasing {
    /// Trims of the configuration.
    fixed: Vec<Trim, MAX_LANES>,
    calibration: LaneTrims,
    forward: f32,
    /// Lanes as of the last call of [`lanes`](Phasing::lanes).
    lanes: Vec<Lane, MAX_LANES>,
    /// Quadrature of these lanes, turns.
    quadrature: f32,
    /// Frequency of these lanes, Hz.
    hz: f32,
}

/// Converts turns to 2^32 a turn, wrapping.
fn phase_of_turns(turns: f32) -> u32 {
    // In units of 2^-30 turns, so that every offset from minus two turns to two fits.
    ((turns * 1_073_741_824.0) as i32 as u32) << 2
}

/// Returns the largest gain of a lane, at least one: a voltage limit applies to that lane.
pub fn loudest(phasing: &PhasingConfig) -> f32 {
    loudest_of(|lane| phasing.gain_trim.get(lane).copied().unwrap_or(1.0), &phasing.calibration)
}

fn loudest_of(fixed: impl Fn(usize) -> f32, calibration: &LaneTrims) -> f32 {
    let calibrated =
        |lane: usize| calibration.iter().filter_map(|point| point.lanes.get(lane)).map(|trim| trim.gain).fold(1.0, f32::max);
    (0..MAX_LANES).map(|lane| fixed(lane) * calibrated(lane)).fold(1.0, f32::max)
}

fn checked(trim: Trim) -> Result<Trim, Error> {
    PhasingConfig::PHASE_TRIM_TURNS.check(trim.phase_turns)?;
    PhasingConfig::GAIN_TRIM.check(trim.gain)?;
    Ok(trim)
}

/// Checks the result of a calibration.
pub(crate) fn check_calibration(calibration: &LaneTrims) -> Result<(), Error> {
    if !calibration.windows(2).all(|pair| pair[0].hz < pair[1].hz) {
        return Err(Error::TrimOrder);
    }
    calibration.iter().flat_map(|point| point.lanes).try_for_each(|trim| checked(trim).map(|_| ()))
}

impl Phasing {
    /// Builds the lanes, and checks their trims. Missing trims are neutral.
    pub fn build(config: &Config) -> Result<Self, Error> {
        let phasing = &config.phasing;
        let fixed = |lane: usize| Trim {
            phase_turns: phasing.phase_trim_turns.get(lane).copied().unwrap_or(0.0),
            gain: phasing.gain_trim.get(lane).copied().unwrap_or(1.0),
        };
        // A trim is checked even if its lane is not in use.
        let mut fixed = (0..MAX_LANES).map(|lane| checked(fixed(lane))).collect::<Result<Vec<_, MAX_LANES>, Error>>()?;
        fixed.truncate(config.lanes.into());
        check_calibration(&phasing.calibration)?;
        let forward = match phasing.direction {
            Direction::Forward => MAX_QUADRATURE,
            Direction::Reverse => -MAX_QUADRATURE,
        };
        let calibration = phasing.calibration.clone();
        Ok(Phasing { fixed, calibration, forward, lanes: Vec::new(), quadrature: 0.0, hz: 0.0 })
    }

    /// Returns the number of lanes.
    pub fn count(&self) -> usize {
        self.fixed.len()
    }

    /// Returns the ordered quadrature, or the configured one, and `true` if it had to be limited.
    /// NaN gives the configured one.
    pub fn quadrature(&self, ordered: Option<Turns>) -> (f32, bool) {
        match ordered {
            Some(Turns(turns)) if !turns.is_nan() => (turns.clamp(-MAX_QUADRATURE, MAX_QUADRATURE), turns.abs() > MAX_QUADRATURE),
            _ => (self.forward, false),
        }
    }

    /// Returns the nominal offset of each lane, 2^32 a turn.
    pub fn offsets(quadrature: f32) -> [u32; MAX_LANES] {
        Self::turns(quadrature).map(phase_of_turns)
    }

    /// Returns the nominal offset of each lane, turns.
    fn turns(quadrature: f32) -> [f32; MAX_LANES] {
        OFFSETS.map(|(turns, quadratures)| turns + quadratures * quadrature)
    }

    /// Returns the trims of the calibration.
    pub fn calibration(&self) -> &LaneTrims {
        &self.calibration
    }

    /// Replaces the calibration, and returns the former one.
    pub fn trim(&mut self, calibration: LaneTrims) -> LaneTrims {
        self.lanes.clear();
        core::mem::replace(&mut self.calibration, calibration)
    }

    /// Returns the largest gain of a lane with the present trims, at least one.
    pub fn loudest(&self) -> f32 {
        loudest_of(|lane| self.fixed.get(lane).map_or(1.0, |trim| trim.gain), &self.calibration)
    }

    /// Returns the lanes at a frequency and a quadrature.
    pub fn lanes(&mut self, hz: f32, quadrature: f32) -> &Vec<Lane, MAX_LANES> {
        let moved = !self.calibration.is_empty() && (hz - self.hz).abs() > RETRIM_REL * hz;
        if self.lanes.is_empty() || quadrature != self.quadrature || moved {
            self.set(hz, quadrature);
        }
        &self.lanes
    }

    /// Returns the gain of a lane, as it was last played.
    pub(crate) fn gain(&self, lane: usize) -> f32 {
        self.lanes.get(lane).map_or(1.0, |lane| lane.gain)
    }

    /// Computes the lanes at a frequency and a quadrature.
    #[inline(never)]
    fn set(&mut self, hz: f32, quadrature: f32) {
        (self.hz, self.quadrature) = (hz, quadrature);
        let lanes = self.fixed.iter().zip(Self::turns(quadrature)).enumerate();
        self.lanes = lanes.map(|(n, (fixed, offset_turns))| self.lane(n, fixed, offset_turns)).collect();
        for n in 2..self.lanes.len() {
            self.lanes[n].mirrors = self.lanes[n].row == -self.lanes[n - 2].row && self.lanes[n].gain == self.lanes[n - 2].gain;
        }
    }

    fn lane(&self, lane: usize, fixed: &Trim, offset_turns: f32) -> Lane {
        let found = self.calibrated(lane);
        let gain = fixed.gain * found.gain;
        let offset = phase_of_turns(offset_turns + fixed.phase_turns + found.phase_turns);
        Lane { offset, gain, row: sine::rotation(u64::from(offset) << 32) * gain, mirrors: false }
    }

    /// Returns the trim of a lane from the calibration, interpolated linearly in frequency.
    fn calibrated(&self, lane: usize) -> Trim {
        let above = self.calibration.iter().position(|point| point.hz >= self.hz).unwrap_or(self.calibration.len());
        let at = |point: usize| self.calibration.get(point).and_then(|point| Some((point.hz, *point.lanes.get(lane)?)));
        match (above.checked_sub(1).and_then(at), at(above)) {
            (Some((low_hz, low)), Some((high_hz, high))) => {
                let part = (self.hz - low_hz) / (high_hz - low_hz);
                let between = |low: f32, high: f32| low + part * (high - low);
                Trim { phase_turns: between(low.phase_turns, high.phase_turns), gain: between(low.gain, high.gain) }
            }
            (Some((_, trim)), None) | (None, Some((_, trim))) => trim,
            (None, None) => Trim::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::config::TrimPoint;

    fn phasing(lanes: usize) -> Phasing {
        let fixed = core::iter::repeat_n(Trim::default(), lanes).collect();
        Phasing { fixed, calibration: Vec::new(), forward: 0.25, lanes: Vec::new(), quadrature: 0.0, hz: 0.0 }
    }

    fn offsets(phasing: &mut Phasing, hz: f32, quadrature: f32) -> std::vec::Vec<u32> {
        phasing.lanes(hz, quadrature).iter().map(|lane| lane.offset).collect()
    }

    #[test]
    fn four_lanes_are_a_quarter_turn_apart_in_either_direction() {
        assert_eq!(offsets(&mut phasing(4), 40e3, 0.25), [0, 1 << 30, 2 << 30, 3 << 30]);
        assert_eq!(offsets(&mut phasing(4), 40e3, -0.25), [0, 3 << 30, 2 << 30, 1 << 30]);
        assert_eq!(offsets(&mut phasing(4), 40e3, 0.0), [0, 0, 2 << 30, 2 << 30]);
    }

    #[test]
    fn a_row_is_the_lane_s_gain_and_direction() {
        let mut phasing = phasing(2);
        phasing.fixed[1] = Trim { phase_turns: 0.125, gain: 0.5 };
        let lane = phasing.lanes(40e3, -0.25)[1];
        assert_eq!(lane.offset, (3 << 30) + (1 << 29));
        assert!((lane.row - Phasor::new(0.353_553, -0.353_553)).norm_sqr() < 1e-11, "{lane:?}");
    }

    #[test]
    fn trims_are_interpolated_linearly_in_frequency() {
        let mut phasing = phasing(2);
        let point = |hz, phase_turns, gain| {
            let mut lanes = [Trim::default(); MAX_LANES];
            lanes[1] = Trim { phase_turns, gain };
            TrimPoint { hz, lanes }
        };
        phasing.trim([point(39e3, 0.01, 1.0), point(41e3, 0.03, 1.2)].into_iter().collect());
        for (hz, phase_turns, gain) in [(30e3, 0.01, 1.0), (39.5e3, 0.015, 1.05), (41e3, 0.03, 1.2), (50e3, 0.03, 1.2)] {
            let lane = phasing.lanes(hz, 0.0)[1];
            assert!((lane.offset as f32 / 4_294_967_296.0 - phase_turns).abs() < 1e-6, "{hz} {lane:?}");
            assert!((lane.gain - gain).abs() < 1e-6, "{hz} {lane:?}");
        }
    }

    #[test]
    fn the_quadrature_is_limited_and_reports_it() {
        let phasing = phasing(4);
        assert_eq!(phasing.quadrature(None), (0.25, false));
        assert_eq!(phasing.quadrature(Some(Turns(0.1))), (0.1, false));
        assert_eq!(phasing.quadrature(Some(Turns(-0.3))), (-0.25, true));
        assert_eq!(phasing.quadrature(Some(Turns(f32::NAN))), (0.25, false));
    }
}
