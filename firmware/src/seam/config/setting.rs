//! What is known of one number that a user sets: its name and its range.

use crate::seam::config::Range;
use crate::seam::error::{Error, in_range};

/// The name of a setting and the range of its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Path of the setting in the configuration, with its unit.
    pub name: &'static str,
    /// The smallest value that it may have.
    pub min: f64,
    /// The largest value that it may have.
    pub max: f64,
}

impl Setting {
    /// The values that it may have as a parameter.
    pub(crate) const fn range(&self) -> Range {
        Range::Within(self.min as f32, self.max as f32)
    }

    /// The values that it may have as a limit.
    pub(crate) const fn up_to_ceiling(&self) -> Range {
        Range::UpToCeiling(self.min as f32, self.max as f32)
    }

    /// The values that it may have as a scale factor.
    pub(crate) const fn scale(&self) -> Range {
        Range::Scale(self.min as f32, self.max as f32)
    }

    /// Refuses a value outside the range.
    // Not inlined: a configuration has dozens of them.
    #[inline(never)]
    pub(crate) fn check(&self, value: f32) -> Result<(), Error> {
        self.check_double(value.into()).map(drop)
    }

    /// Refuses a value outside the range, of double precision.
    pub(crate) fn check_double(&self, value: f64) -> Result<f64, Error> {
        in_range(self.name, value, self.min, self.max)
    }

    /// Refuses a value beyond `most`, or below the range; `most` itself is always allowed.
    pub(crate) fn check_up_to(&self, value: f32, most: f32) -> Result<(), Error> {
        let most = most.into();
        in_range(self.name, value.into(), self.min.min(most), most).map(drop)
    }

    /// Refuses a value outside what other settings leave of the range.
    pub(crate) fn check_within(&self, value: f64, min: f64, max: f64) -> Result<f64, Error> {
        in_range(self.name, value, self.min.max(min), self.max.min(max))
    }
}
