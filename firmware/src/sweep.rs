//! Time to frequency. Hold: the frequency stays where it was put until the scan or the tracker moves it, and moving it
//! never breaks the phase.

use crate::error::{Error, in_range};
use crate::nco::{cycles_per_sample, tuning_word};
use crate::units::Hertz;

/// A held frequency, as an offset from the nominal one.
#[derive(Clone, Debug)]
pub struct Hold {
    nominal_hz: f32,
    nominal_word: u64,
    words_per_hz: f32,
    offset_hz: f32,
}

impl Hold {
    /// `frequency_hz` nominal frequency at `sample_hz` samples a second.
    pub fn build(frequency_hz: f32, sample_hz: f32) -> Result<Self, Error> {
        in_range("sample_hz", sample_hz.into(), 1e3, 20e6)?;
        in_range("drive.frequency_hz", frequency_hz.into(), 1.0, f64::from(sample_hz) * 0.45)?;
        Ok(Hold {
            nominal_hz: frequency_hz,
            nominal_word: tuning_word(f64::from(frequency_hz) / f64::from(sample_hz)),
            words_per_hz: (1.0 / (f64::from(sample_hz) * cycles_per_sample(1))) as f32,
            offset_hz: 0.0,
        })
    }

    /// Moves to `offset_hz` from the nominal frequency.
    pub fn retune(&mut self, offset_hz: f32) {
        self.offset_hz = offset_hz;
    }

    /// The offset from the nominal frequency, Hz. It resolves 1e-4 Hz where the frequency in f32 resolves 4e-3.
    pub fn offset_hz(&self) -> f32 {
        self.offset_hz
    }

    /// The frequency held.
    pub fn frequency(&self) -> Hertz {
        Hertz(self.nominal_hz + self.offset_hz)
    }

    /// The tuning word of the frequency held.
    pub fn word(&self) -> u64 {
        // The offset alone goes through f32, so that its rounding is relative to the offset and not to the frequency.
        self.nominal_word.wrapping_add_signed((self.offset_hz * self.words_per_hz) as i64)
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
        }
    }

    #[test]
    fn frequency_must_be_below_half_the_sample_rate() {
        assert!(matches!(Hold::build(600e3, 1e6), Err(Error::OutOfRange { parameter: "drive.frequency_hz", .. })));
    }
}
