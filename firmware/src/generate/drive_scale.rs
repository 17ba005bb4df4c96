//! Conversion of volts to codes of the drive converter.

use crate::seam::config::FrontEnd;
use crate::seam::error::{Error, in_range};

/// The drive converter: `code = mid + volts / volt_per_lsb`, rounded to nearest. The caller keeps
/// the drive within the headroom.
#[derive(Clone, Debug)]
pub struct DriveScale {
    mid_code: u16,
    lsb_per_volt: f32,
    headroom: f32,
}

impl DriveScale {
    /// Builds the scale, and checks that zero volts is within the codes.
    pub(crate) fn build(front_end: &FrontEnd) -> Result<Self, Error> {
        in_range("front_end.drive_mid_code", front_end.drive_mid_code.into(), 8.0, f64::from(front_end.drive_max_code) - 8.0)?;
        Ok(DriveScale {
            mid_code: front_end.drive_mid_code,
            lsb_per_volt: 1.0 / front_end.drive_volt_per_lsb,
            // One code less for rounding, and one for dither.
            headroom: f32::from(front_end.drive_mid_code.min(front_end.drive_max_code - front_end.drive_mid_code)) - 2.0,
        })
    }

    /// Returns the code of zero volts.
    pub(crate) fn silence(&self) -> u16 {
        self.mid_code
    }

    /// Returns the number of codes per volt.
    pub(crate) fn lsb_per_volt(&self) -> f32 {
        self.lsb_per_volt
    }

    /// Returns the largest amplitude without clipping, codes.
    pub(crate) fn headroom(&self) -> f32 {
        self.headroom
    }

    /// Returns the largest amplitude without clipping, V.
    pub(crate) fn range_v(&self) -> f32 {
        self.headroom / self.lsb_per_volt
    }

    /// Returns an offset in codes, after which truncation rounds a value within the headroom to the
    /// nearest code.
    #[inline]
    pub(crate) fn rounding_base(&self) -> f32 {
        f32::from(self.mid_code) + 0.5
    }
}
