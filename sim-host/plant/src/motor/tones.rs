//! Phasors of the lanes, and their deviation from equal amplitudes a quarter turn apart.
//!
//! The phasors come from the codes of one block, by least squares of a cosine and a sine at the
//! drive frequency (exact at any block length), times the amplifier's error at that frequency.
//! Codes are used instead of voltages because the converter's images would fold onto the tone.

use std::f64::consts::TAU;

use firmware::seam::block::MAX_LANES;

use scene::Direction;

/// Largest deviations of the lanes from the ideal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaneErrors {
    /// Largest phase error relative to lane 0, degrees.
    pub phase_deg: f64,
    /// Largest amplitude error relative to lane 0, per cent.
    pub gain_percent: f64,
}

/// Real and imaginary part.
type Phasor = (f64, f64);

/// Returns the phasor of samples at `cycles` turns a sample: `x_n = Re(X e^(2 pi i cycles n))`.
fn phasor(samples: impl Iterator<Item = f64>, cycles: f64) -> Phasor {
    // Normal equations of x = a cos - b sin.
    let (mut cc, mut ss, mut cs, mut xc, mut xs) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (step_sin, step_cos) = libm::sincos(TAU * cycles);
    let (mut sin, mut cos) = (0.0, 1.0);
    for x in samples {
        (cc, ss, cs) = (cc + cos * cos, ss + sin * sin, cs + cos * sin);
        (xc, xs) = (xc + x * cos, xs + x * sin);
        (cos, sin) = (cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin);
    }
    let determinant = cc * ss - cs * cs;
    ((ss * xc - cs * xs) / determinant, -(cc * xs - cs * xc) / determinant)
}

/// Returns the errors of lanes that play `volts` (codes as volts, a list for each lane) through
/// amplifiers with these gains and leads, turns at the nominal frequency. The tone is at `cycles`
/// turns a sample and `ratio` times the nominal frequency. Returns `None` if lane 0 is silent.
pub fn errors<'a>(
    volts: impl Iterator<Item = &'a [f64]>,
    amplifiers: &[(f64, f64); MAX_LANES],
    direction: Direction,
    cycles: f64,
    ratio: f64,
) -> Option<LaneErrors> {
    let quarter = match direction {
        Direction::Forward => 0.25,
        Direction::Reverse => -0.25,
    };
    let mut first = None;
    let mut worst = LaneErrors::default();
    for (lane, (samples, &(gain, lead))) in volts.zip(amplifiers).enumerate() {
        let (re, im) = phasor(samples.iter().copied(), cycles);
        let reversed = if gain < 0.0 { 0.5 } else { 0.0 };
        let turns = libm::atan2(im, re) / TAU + lead * ratio + reversed - quarter * lane as f64;
        let amplitude = gain.abs() * re.hypot(im);
        let &mut (zero_turns, zero_amplitude) = first.get_or_insert((turns, amplitude));
        if zero_amplitude < 1e-9 {
            return None;
        }
        let off = turns - zero_turns;
        worst.phase_deg = worst.phase_deg.max(360.0 * (off - off.round()).abs());
        worst.gain_percent = worst.gain_percent.max(100.0 * (amplitude / zero_amplitude - 1.0).abs());
    }
    first.map(|_| worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_found_in_a_block_of_any_length() {
        let amplifiers = [(1.0, 0.0), (1.02, 0.01), (0.99, -0.02), (1.0, 0.0)];
        for samples in [20, 32, 57] {
            for (direction, turn) in [(Direction::Forward, 0.25), (Direction::Reverse, -0.25)] {
                let lane = |lane: i32| -> Vec<f64> {
                    (0..samples).map(|n| 9.0 * (TAU * (0.04 * f64::from(n) + 0.3 + turn * f64::from(lane))).cos()).collect()
                };
                let lanes: Vec<Vec<f64>> = (0..4).map(lane).collect();
                let found = errors(lanes.iter().map(Vec::as_slice), &amplifiers, direction, 0.04, 1.01).unwrap();
                assert!((found.phase_deg - 7.2 * 1.01).abs() < 1e-9 && (found.gain_percent - 2.0).abs() < 1e-9, "{found:?}");
            }
        }
    }

    #[test]
    fn silence_has_no_errors() {
        let silent = [0.0; 32];
        let lanes = [&silent[..]; 4];
        assert_eq!(errors(lanes.into_iter(), &[(1.0, 0.0); 4], Direction::Forward, 0.04, 1.0), None);
    }
}
