//! Phase-locked PI, normalised by Q.
//!
//! About the resonance, the phase answers a detuning as `phi = -2 pi tau df / (1 + tau s)`, `tau = Q / (pi f)`. A PI with
//! its zero at `1 / tau`, `Kp = B` Hz/rad and `Ki = B / tau`, cancels that pole and leaves a first-order loop of bandwidth
//! `B` at any Q. The blocks on the way (three of 32 us) cost 0.1 rad of phase margin at B = 200 Hz.

use crate::seam::compare::within;
use crate::seam::config::Tracking;
use crate::seam::error::Error;
use crate::seam::phasor::{Phasor, argument};
use crate::seam::units::Turns;

/// How far from a resonance that a scan has just found a lock may be, bandwidths: further, and the phase is another one than it was in the scan.
const REACH: f32 = 0.3;
/// Part by which where it has been of late follows it in a block, and for how many blocks it may stand at the edge of the window without having drifted there.
const LATELY: f32 = 1.0 / 1024.0;
const LEAPT_BLOCKS: u32 = 16;

/// The loop.
#[derive(Clone, Debug)]
pub(crate) struct PhaseLoop {
    window_hz: f32,
    bandwidth_hz: f32,
    block_s: f32,
    /// `block_s / tau`: how far the integral follows the proportional part in one block.
    integral_gain: f32,
    integral_hz: f32,
    /// The last output, offset from the nominal frequency.
    offset_hz: f32,
    /// Where it was seeded, and how far from there a lock may be, Hz.
    seeded_hz: f32,
    reach_hz: f32,
    /// Where it has been of late, Hz, and blocks at the edge of the window since it was elsewhere.
    lately_hz: f32,
    leapt_blocks: u32,
}

impl PhaseLoop {
    /// A loop about `frequency_hz`, updated every `block_s` seconds.
    pub(crate) fn build(tracking: &Tracking, frequency_hz: f32, block_s: f32) -> Result<Self, Error> {
        Tracking::BANDWIDTH_HZ.check_within(tracking.bandwidth_hz.into(), 0.0, 0.02 / f64::from(block_s))?;
        Ok(PhaseLoop {
            window_hz: tracking.span * frequency_hz,
            bandwidth_hz: tracking.bandwidth_hz,
            block_s,
            integral_gain: 0.0,
            integral_hz: 0.0,
            offset_hz: 0.0,
            seeded_hz: 0.0,
            reach_hz: f32::INFINITY,
            lately_hz: 0.0,
            leapt_blocks: 0,
        })
    }

    /// Starts from a known resonance: its offset from the nominal frequency and its time constant.
    pub(crate) fn seed(&mut self, offset_hz: f32, time_constant_s: f32) {
        self.integral_hz = offset_hz;
        self.offset_hz = offset_hz;
        self.integral_gain = self.block_s / time_constant_s;
        (self.seeded_hz, self.reach_hz) = (offset_hz, REACH / (core::f32::consts::PI * time_constant_s));
        (self.lately_hz, self.leapt_blocks) = (offset_hz, 0);
    }

    /// Whether it has leapt to the edge of the window: a resonance drifts there.
    pub(crate) fn has_leapt(&self) -> bool {
        self.leapt_blocks > LEAPT_BLOCKS
    }

    /// Whether it has gone further from where it was seeded than a lock there may be.
    pub(crate) fn is_astray(&self) -> bool {
        (self.integral_hz - self.seeded_hz).abs() > self.reach_hz
    }

    /// Follows one block's phase error and returns it.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(crate) fn update(&mut self, error: Phasor) -> Turns {
        let phase = argument(error);
        let proportional = self.bandwidth_hz * core::f32::consts::TAU * phase.0;
        // The integral is clamped to the window, which is all the anti-windup a first-order loop needs.
        self.integral_hz = within(self.integral_hz + self.integral_gain * proportional, -self.window_hz, self.window_hz);
        self.offset_hz = within(self.integral_hz + proportional, -self.window_hz, self.window_hz);
        self.lately_hz += LATELY * (self.offset_hz - self.lately_hz);
        let leapt = self.limited() && (self.offset_hz - self.lately_hz).abs() > self.reach_hz;
        self.leapt_blocks = if leapt { self.leapt_blocks.saturating_add(1) } else { 0 };
        phase
    }

    /// The resonance now has another time constant.
    pub(crate) fn set_time_constant(&mut self, time_constant_s: f32) {
        self.integral_gain = self.block_s / time_constant_s;
    }

    /// Goes along with who leads, so that it could take over at any time, and returns one block's phase error.
    pub(crate) fn accompany(&mut self, error: Phasor, offset_hz: f32) -> Turns {
        self.integral_hz = within(offset_hz, -self.window_hz, self.window_hz);
        self.offset_hz = self.integral_hz;
        argument(error)
    }

    /// Forgets the proportional part: the frequency to hold while there is nothing to follow.
    pub(crate) fn hold(&mut self) {
        self.offset_hz = self.integral_hz;
    }

    /// The largest offset, Hz.
    pub(crate) fn window_hz(&self) -> f32 {
        self.window_hz
    }

    /// The frequency to drive, as an offset from the nominal one, Hz.
    pub(crate) fn offset_hz(&self) -> f32 {
        self.offset_hz
    }

    /// The smoothed frequency estimate, as an offset from the nominal one, Hz.
    pub(crate) fn estimate_hz(&self) -> f32 {
        self.integral_hz
    }

    /// Whether the window stops the loop from going where it wants.
    pub(crate) fn limited(&self) -> bool {
        self.offset_hz.abs() >= self.window_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::config::TrackingMode;

    const BLOCK_S: f32 = 32e-6;

    /// Closes the loop on the linear phase response of a resonance `detuning` away, with two blocks of delay, and
    /// returns how many blocks it takes to stay within `tolerance_hz`.
    fn settle(q: f32, assumed_q: f32, detuning: f32, tolerance_hz: f32) -> usize {
        let tracking = Tracking {
            mode: TrackingMode::PhaseLock,
            span: 0.025,
            bandwidth_hz: 200.0,
            nominal_c0_f: Some(300e-9),
            ..Tracking::new(q)
        };
        let mut pll = PhaseLoop::build(&tracking, 40e3, BLOCK_S).unwrap();
        let tau = q / (core::f32::consts::PI * 40e3);
        pll.seed(0.0, assumed_q / (core::f32::consts::PI * 40e3));
        let (mut phase, mut played, mut last_out) = (0.0_f32, [0.0_f32; 2], 0);
        for n in 0..2000 {
            let error = played[0] - detuning;
            if error.abs() > tolerance_hz {
                last_out = n;
            }
            phase += BLOCK_S / tau * (-core::f32::consts::TAU * tau * error - phase);
            pll.update(Phasor::new(libm::cosf(phase), libm::sinf(phase)));
            played = [played[1], pll.offset_hz()];
        }
        last_out
    }

    #[test]
    fn bandwidth_does_not_depend_on_q() {
        // First order at 200 Hz: 100 Hz to 4 Hz takes ln(25) / (2 pi 200) s = 80 blocks.
        for q in [20.0, 65.0, 200.0] {
            let blocks = settle(q, q, 100.0, 4.0);
            assert!((50..110).contains(&blocks), "Q {q}: {blocks} blocks");
        }
    }

    #[test]
    fn a_q_wrong_by_two_still_locks() {
        assert!(settle(65.0, 130.0, 100.0, 4.0) < 400);
        assert!(settle(65.0, 32.0, 100.0, 4.0) < 400);
    }

    #[test]
    fn a_lock_is_where_the_scan_was_to_a_third_of_the_bandwidth() {
        let tracking = Tracking { bandwidth_hz: 200.0, span: 0.025, ..Tracking::new(65.0) };
        let mut pll = PhaseLoop::build(&tracking, 40e3, BLOCK_S).unwrap();
        for (hz, astray) in [(0.0, false), (180.0, false), (-180.0, false), (190.0, true), (-190.0, true)] {
            pll.seed(300.0, 65.0 / (core::f32::consts::PI * 40e3));
            pll.accompany(Phasor::new(1.0, 0.0), 300.0 + hz);
            assert_eq!(pll.is_astray(), astray, "{hz} Hz of a bandwidth of 615 Hz");
        }
    }

    /// A phase that is suddenly another one takes the loop to the edge within some blocks; a resonance that drifts takes thousands.
    #[test]
    fn what_leaps_to_the_edge_of_the_window_is_no_drift() {
        let tracking = Tracking { bandwidth_hz: 200.0, span: 0.025, ..Tracking::new(65.0) };
        let leaps = |turns: f32| {
            let mut pll = PhaseLoop::build(&tracking, 40e3, BLOCK_S).unwrap();
            pll.seed(0.0, 65.0 / (core::f32::consts::PI * 40e3));
            let angle = core::f32::consts::TAU * turns;
            let error = Phasor::new(libm::cosf(angle), libm::sinf(angle));
            let mut step = || {
                pll.update(error);
                (pll.limited(), pll.has_leapt())
            };
            let arrives = (0..20_000).position(|_| step().0).unwrap();
            (arrives, (1..200).find(|_| step().1))
        };
        let (sudden, known) = leaps(0.16);
        assert!(sudden < 200 && known == Some(LEAPT_BLOCKS), "{sudden}: {known:?}");
        let (slow, known) = leaps(0.002);
        assert!(slow > 6000 && known.is_none(), "{slow}: {known:?}");
    }

    #[test]
    fn the_window_bounds_the_loop() {
        assert_eq!(settle(65.0, 65.0, 1500.0, 400.0), 1999);
    }
}
