//! Voltage and current against a reference of constant frequency, one phasor a block.
//!
//! ```text
//! X(k) = (2 / N) sum over blocks k - 1 and k of triangle(n) x(n) exp(-j theta(n)),    theta(n) = theta0 + n omega
//! ```
//!
//! Unlike the [lock-in](crate::demod), which follows the drive's own phase, this is the same linear filter for all that is heard, whatever
//! the drive does: what voltage and current have to do with one another stays exactly what it was before the filter, and its droop is the
//! same in both. The triangle, two blocks long, takes from the image at twice the frequency what a boxcar would fold into the band.

use crate::block::SenseBlock;
use crate::convert::{Convert, SenseScale};
use crate::demod::Sensed;
use crate::phasor::Phasor;
use crate::shape::sine;

/// The reference, and what the rising half of the triangle has gathered.
#[derive(Clone, Debug, Default)]
pub struct Baseband {
    word: u64,
    phase: u64,
    rising: Sensed,
}

impl Baseband {
    /// Starts anew with a reference of this tuning word. The first phasor, which lacks its rising half, is to be thrown away.
    pub fn restart(&mut self, word: u64) {
        *self = Baseband { word, ..Baseband::default() };
    }

    /// Takes a block.
    pub fn take(&mut self, convert: &Convert, sense: &SenseBlock) -> Sensed {
        let samples = sense.v.len().min(sense.i.len());
        let turn = sine::rotation(self.word).conj();
        let mut reference = sine::rotation(self.phase).conj();
        let (mut v, mut i) = (Moments::default(), Moments::default());
        let (v_zero, i_zero) = (convert.v.zero(), convert.i.zero());
        for (&v_code, &i_code) in sense.v.iter().zip(&sense.i) {
            v.add(reference * (f32::from(v_code) - v_zero));
            i.add(reference * (f32::from(i_code) - i_zero));
            reference *= turn;
        }
        self.phase = self.phase.wrapping_add(self.word.wrapping_mul(samples as u64));
        let ((v_falling, v_rising), (i_falling, i_rising)) = (v.halves(samples, &convert.v), i.halves(samples, &convert.i));
        let heard = Sensed { v: self.rising.v + v_falling, i: self.rising.i + i_falling };
        self.rising = Sensed { v: v_rising, i: i_rising };
        heard
    }
}

/// Sum, and the sum of the sums so far, which weighs the first sample most.
#[derive(Clone, Copy, Default)]
struct Moments {
    sum: Phasor,
    sums: Phasor,
}

impl Moments {
    #[inline]
    fn add(&mut self, x: Phasor) {
        self.sum += x;
        self.sums += self.sum;
    }

    /// By the falling and by the rising half of the triangle, in SI.
    fn halves(&self, samples: usize, channel: &SenseScale) -> (Phasor, Phasor) {
        if samples == 0 {
            return (Phasor::default(), Phasor::default());
        }
        let count = samples as f32;
        let falling = self.sums / count;
        (channel.scale(falling * (2.0 / count)), channel.scale((self.sum - falling) * (2.0 / count)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::Codes;
    use crate::nco::tuning_word;
    use crate::phasor::magnitude;
    use crate::scan::bench::front_end;

    fn heard(hz: f64, reference_hz: f64) -> Phasor {
        let convert = Convert::build(&front_end()).unwrap();
        let mut baseband = Baseband::default();
        baseband.restart(tuning_word(reference_hz / 1e6));
        let mut last = Sensed::default();
        for block in 0..3 {
            let wave = |n: usize| 1500.0 * libm::cos(core::f64::consts::TAU * hz * 1e-6 * (32 * block + n) as f64);
            let codes: Codes = (0..32).map(|n| libm::round(2048.0 + wave(n)) as u16).collect();
            last = baseband.take(&convert, &SenseBlock { v: codes.clone(), i: codes, ..SenseBlock::default() });
        }
        last.v / (1500.0 * front_end().volt_per_lsb)
    }

    #[test]
    fn a_tone_at_the_reference_is_one() {
        // The image at 80 kHz leaves 1.4 %.
        assert!((heard(40_000.0, 40_000.0) - Phasor::new(1.0, 0.0)).norm_sqr() < 0.02 * 0.02);
    }

    /// Twice 46.875 kHz is three times the block rate: there the image of one side of the band would fold onto the other.
    #[test]
    fn an_image_that_folds_into_the_band_is_small() {
        let image = magnitude(heard(-2.0 * 46_875.0 + 47_875.0, 46_875.0));
        assert!(image < 2e-3, "{image}");
    }
}
