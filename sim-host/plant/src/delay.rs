//! A pure delay between DAC and amplifier.
//!
//! Whole samples wait in a line. What is left of the delay, the fraction of a sample, is exact because a DAC holds: within each sample
//! the one before goes on for so long, and then comes the present one. The line holds values and integrates nothing, so that
//! it does not count as states.

use std::collections::VecDeque;

/// A delay this close to a whole number of samples is one, in samples: the round-off of its product with the sample rate.
const WHOLE: f64 = 1e-9;

/// A drive that comes late.
#[derive(Clone, Debug)]
pub struct Delay {
    /// What waits, the next to come first, V.
    line: VecDeque<f64>,
    /// What came last, V.
    last: f64,
    /// The fraction of a sample.
    fraction: f64,
}

impl Delay {
    /// A delay of so many samples, at rest; none if it is zero.
    pub fn of(samples: f64) -> Option<Self> {
        let nearest = samples.round();
        let (whole, fraction) =
            if (samples - nearest).abs() < WHOLE { (nearest, 0.0) } else { (samples.floor(), samples.fract()) };
        let line = std::iter::repeat_n(0.0, whole as usize).collect();
        (whole > 0.0 || fraction > 0.0).then_some(Delay { line, last: 0.0, fraction })
    }

    /// How long the sample before goes on into each, in samples, 0 to 1.
    pub fn fraction(&self) -> f64 {
        self.fraction
    }

    /// What comes out in the sample in which `volts` goes in: the voltage at its end, and the one at its beginning.
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
    fn whole_samples_wait_and_the_fraction_is_left() {
        let mut delay = Delay::of(2.25).unwrap();
        let out: Vec<_> = [1.0, 2.0, 3.0, 4.0].map(|volts| delay.pass(volts)).into();
        assert_eq!(out, [(0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (2.0, 1.0)]);
        assert!((delay.fraction() - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_product_that_is_nearly_whole_is_whole() {
        assert_eq!(Delay::of(3e-6 * 1e6).unwrap().fraction(), 0.0);
        assert_eq!(Delay::of(2.999_999_999_9).unwrap().fraction(), 0.0);
        assert!(Delay::of(0.0).is_none());
    }
}
