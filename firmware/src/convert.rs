//! Converter codes to SI and back: the only place that knows what a code is worth.

use crate::block::Codes;
use crate::config::FrontEnd;
use crate::error::{Error, in_range};
use crate::phasor::Phasor;

/// One sense channel: `x = (code - zero) * per_lsb`.
#[derive(Clone, Debug)]
pub struct SenseScale {
    mid_code: u16,
    zero: f32,
    per_lsb: f32,
    max_code: u16,
}

impl SenseScale {
    fn build(parameter: &'static str, per_lsb: f32, mid_code: u16, max_code: u16) -> Result<Self, Error> {
        in_range(parameter, per_lsb.into(), 1e-9, 1e3)?;
        in_range("front_end.sense_mid_code", mid_code.into(), 1.0, f64::from(max_code) - 1.0)?;
        Ok(SenseScale { mid_code, zero: f32::from(mid_code), per_lsb, max_code })
    }

    /// The codes of a block about zero, still in codes: scaling waits until after demodulation.
    pub fn centred<'a>(&self, codes: &'a Codes) -> impl Iterator<Item = f32> + 'a {
        let zero = self.zero;
        codes.iter().map(move |&code| f32::from(code) - zero)
    }

    /// A phasor in codes, in SI.
    pub fn scale(&self, codes: Phasor) -> Phasor {
        codes * self.per_lsb
    }

    /// Mean of a block, in codes about the present zero.
    pub fn mean_code(&self, codes: &Codes) -> f32 {
        self.centred(codes).sum::<f32>() / codes.len().max(1) as f32
    }

    /// Rms of a block about its own mean, in codes.
    pub fn rms_code(&self, codes: &Codes) -> f32 {
        let mean = self.mean_code(codes);
        libm::sqrtf(self.centred(codes).map(|code| (code - mean) * (code - mean)).sum::<f32>() / codes.len().max(1) as f32)
    }

    /// How many codes a value in SI is.
    pub fn codes(&self, value: f32) -> f32 {
        value / self.per_lsb
    }

    /// How many samples of a block are beyond `limit` (in SI) on either side of zero.
    pub fn beyond(&self, codes: &Codes, limit: f32) -> usize {
        let limit = self.codes(limit);
        self.centred(codes).filter(|code| code.abs() > limit).count()
    }

    /// Moves the zero by a measured offset, in codes.
    pub fn shift_zero(&mut self, codes: f32) {
        self.zero += codes;
    }

    /// Forgets measured offsets.
    pub fn restore_zero(&mut self) {
        self.zero = f32::from(self.mid_code);
    }

    /// Full scale to one side, in codes.
    pub fn half_range(&self) -> f32 {
        0.5 * f32::from(self.max_code)
    }

    /// How many samples of a block stand at either end of the converter.
    pub fn clipped(&self, codes: &Codes) -> usize {
        codes.iter().filter(|&&code| code == 0 || code >= self.max_code).count()
    }
}

/// The drive converter: `code = mid + volts / volt_per_lsb`, rounded to nearest and saturating.
#[derive(Clone, Debug)]
pub struct DriveScale {
    mid_code: u16,
    lsb_per_volt: f32,
    max_code: f32,
}

impl DriveScale {
    fn build(front_end: &FrontEnd) -> Result<Self, Error> {
        in_range("front_end.drive_volt_per_lsb", front_end.drive_volt_per_lsb.into(), 1e-9, 1e3)?;
        in_range("front_end.drive_mid_code", front_end.drive_mid_code.into(), 1.0, f64::from(front_end.drive_max_code) - 1.0)?;
        Ok(DriveScale {
            mid_code: front_end.drive_mid_code,
            lsb_per_volt: 1.0 / front_end.drive_volt_per_lsb,
            max_code: f32::from(front_end.drive_max_code),
        })
    }

    /// The code that plays zero volts.
    pub fn silence(&self) -> u16 {
        self.mid_code
    }

    /// Codes for one volt.
    pub fn lsb_per_volt(&self) -> f32 {
        self.lsb_per_volt
    }

    /// The code nearest to `lsb` codes above zero volts.
    #[inline]
    pub fn code(&self, lsb: f32) -> u16 {
        // Adding a half and truncating rounds to nearest, because the sum is clamped to be positive.
        (f32::from(self.mid_code) + lsb).clamp(0.0, self.max_code).round_half_up()
    }
}

trait RoundHalfUp {
    fn round_half_up(self) -> u16;
}

impl RoundHalfUp for f32 {
    #[inline]
    fn round_half_up(self) -> u16 {
        // Through i32: one instruction on every target, where a cast to u16 saturates by branches.
        (self + 0.5) as i32 as u16
    }
}

/// All converters of the front end.
#[derive(Clone, Debug)]
pub struct Convert {
    /// Voltage sense.
    pub v: SenseScale,
    /// Current sense.
    pub i: SenseScale,
    /// Drive.
    pub drive: DriveScale,
}

impl Convert {
    /// Checks the scale factors.
    pub fn build(front_end: &FrontEnd) -> Result<Self, Error> {
        let sense =
            |parameter, per_lsb| SenseScale::build(parameter, per_lsb, front_end.sense_mid_code, front_end.sense_max_code);
        Ok(Convert {
            v: sense("front_end.volt_per_lsb", front_end.volt_per_lsb)?,
            i: sense("front_end.ampere_per_lsb", front_end.ampere_per_lsb)?,
            drive: DriveScale::build(front_end)?,
        })
    }
}
