//! A pure delay between DAC and amplifier.
//!
//! Whole samples wait in a queue. The remaining fraction of a sample is exact because a DAC holds:
//! each output sample begins with the previous value for that fraction, followed by the present
//! value. The queue integrates nothing, so it does not count as states.

use std::collections::VecDeque;

/// Distance from a whole number below which a delay counts as whole, samples: the rounding error of
/// delay times sample rate.
const WHOLE_TOLERANCE_SAMPLES: f64 = 1e-9;

/// A delayed drive signal.
#[derive(Clone, Debug)]
pub struct Delay {
    /// Queued voltages, the next one first, V.
    line: VecDeque<f64>,
    /// Previous output, V.
    last: f64,
    /// Fractional part of the delay, samples.
    fraction: f64,
}

impl Delay {
    /// Creates a delay of `samples`, at rest; `None` if it is zero.
    pub fn from_samples(samples: f64) -> Option<Self> {
        let nearest = samples.round();
        let (whole, fraction) =
            if (samples - nearest).abs() < WHOLE_TOLERANCE_SAMPLES { (nearest, 0.0) } else { (samples.floor(), samples.fract()) };
        let line = std::iter::repeat_n(0.0, whole as usize).collect();
        (whole > 0.0 || fraction > 0.0).then_some(Delay { line, last: 0.0, fraction })
    }

    /// Returns the fraction of each sample, 0 to 1, for which the previous one is still held.
    pub fn fraction(&self) -> f64 {
        self.fraction
    }

    /// Accepts `volts` for this sample. Returns the output at the end of the sample, and the one at
    /// its beginning.
    pub fn pass(&mut self, volts: f64) -> (f64, f64) {
        self.line.push_back(volts);
        let now = self.line.pop_front().unwrap_or(volts);
        (now, std::mem::replace(&mut self.last, now))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_samples_are_queued_and_the_fraction_remains() {
        let mut delay = Delay::from_samples(2.25).unwrap();
        let out: Vec<_> = [1.0, 2.0, 3.0, 4.0].map(|volts| delay.pass(volts)).into();
        assert_eq!(out, [(0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (2.0, 1.0)]);
        assert!((delay.fraction() - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_nearly_whole_delay_is_whole() {
        assert_eq!(Delay::from_samples(3e-6 * 1e6).unwrap().fraction(), 0.0);
        assert_eq!(Delay::from_samples(2.999_999_999_9).unwrap().fraction(), 0.0);
        assert!(Delay::from_samples(0.0).is_none());
    }
}
