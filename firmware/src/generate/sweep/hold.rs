//! Hold: the frequency is constant until the scan, the tracker or an order changes it.

use crate::generate::nco::{cycles_per_sample, tuning_word};
use crate::generate::sweep::MAX_FREQUENCY_REL;
use crate::seam::config::Drive;
use crate::seam::error::Error;

/// Binary logarithm of the resolution of offsets, tuning words. 2^30 words are 6e-5 Hz at 1 Msps,
/// so that offsets up to an eighth of the sample rate fit into 32 bits.
const OFFSET_STEP_BITS: u32 = 30;

/// Held frequency, as an offset from the nominal one.
#[derive(Clone, Debug)]
pub struct Hold {
    nominal_hz: f32,
    nominal_word: u64,
    /// Number of steps of 2^[`OFFSET_STEP_BITS`] words in a hertz of offset.
    steps_per_hz: f32,
    hz_per_high_word: f32,
    offset_hz: f32,
    word: u64,
}

impl Hold {
    /// Builds a hold at the nominal frequency `frequency_hz`, for `sample_hz` samples a second.
    pub fn build(frequency_hz: f32, sample_hz: f32) -> Result<Self, Error> {
        Drive::FREQUENCY_HZ.check_within(frequency_hz.into(), 0.0, f64::from(sample_hz) * MAX_FREQUENCY_REL)?;
        let nominal_word = tuning_word(f64::from(frequency_hz) / f64::from(sample_hz));
        Ok(Hold {
            nominal_hz: frequency_hz,
            nominal_word,
            steps_per_hz: (1.0 / (f64::from(sample_hz) * cycles_per_sample(1 << OFFSET_STEP_BITS))) as f32,
            hz_per_high_word: (f64::from(sample_hz) * cycles_per_sample(1 << 32)) as f32,
            offset_hz: 0.0,
            word: nominal_word,
        })
    }

    /// Sets the frequency to `offset_hz` from the nominal one.
    pub fn retune(&mut self, offset_hz: f32) {
        if offset_hz != self.offset_hz {
            self.offset_hz = offset_hz;
            // The offset alone goes through f32, so that its rounding is relative to the offset and
            // not to the frequency.
            self.word =
                self.nominal_word.wrapping_add_signed(i64::from((offset_hz * self.steps_per_hz) as i32) << OFFSET_STEP_BITS);
        }
    }

    /// Returns the tuning word of the held frequency.
    pub fn word(&self) -> u64 {
        self.word
    }

    /// Returns the offset of a tuning word from the nominal frequency, Hz, in steps of 2e-4.
    pub(crate) fn offset_of(&self, word: u64) -> f32 {
        (word.wrapping_sub(self.nominal_word) >> 32) as i32 as f32 * self.hz_per_high_word
    }

    /// Returns the nominal frequency, Hz.
    pub fn nominal_hz(&self) -> f32 {
        self.nominal_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn retuning_resolves_a_tenth_of_a_millihertz() {
        let mut hold = Hold::build(40_000.0, 1e6).unwrap();
        for offset in [0.0, 0.123, -987.654, 1999.9] {
            hold.retune(offset);
            let hz = cycles_per_sample(hold.word()) * 1e6;
            assert!((hz - (40_000.0 + f64::from(offset))).abs() < 1.3e-4, "{offset} gave {hz}");
            assert!((hold.offset_of(hold.word()) - offset).abs() < 6e-4, "{offset}");
        }
    }

    #[test]
    fn frequency_must_be_below_half_the_sample_rate() {
        assert!(matches!(Hold::build(600e3, 1e6), Err(Error::OutOfRange { parameter: "drive.frequency_hz", .. })));
    }
}
