//! Name and range of a setting.

use crate::seam::config::Range;
use crate::seam::error::{Error, in_range};

/// Name of a setting and range of its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Path of the setting in the configuration, with its unit.
    pub name: &'static str,
    /// Smallest allowed value.
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
}

impl Setting {
    /// Returns the range as that of a parameter.
    pub(crate) const fn range(&self) -> Range {
        Range::Within(self.min as f32, self.max as f32)
    }

    /// Returns the range as that of a limit.
    pub(crate) const fn up_to_ceiling(&self) -> Range {
        Range::UpToCeiling(self.min as f32, self.max as f32)
    }

    /// Returns the range as that of a scale factor.
    pub(crate) const fn scale(&self) -> Range {
        Range::Scale(self.min as f32, self.max as f32)
    }

    /// Checks that a value is within the range.
    // Not inlined: a configuration has dozens of checks.
    #[inline(never)]
    pub(crate) fn check(&self, value: f32) -> Result<(), Error> {
        self.check_double(value.into()).map(drop)
    }

    /// Checks that a value of double precision is within the range, and returns it.
    pub(crate) fn check_double(&self, value: f64) -> Result<f64, Error> {
        in_range(self.name, value, self.min, self.max)
    }

    /// Checks that a value is not above `most` or below the range; `most` itself is always allowed.
    pub(crate) fn check_up_to(&self, value: f32, most: f32) -> Result<(), Error> {
        let most = most.into();
        in_range(self.name, value.into(), self.min.min(most), most).map(drop)
    }

    /// Checks that a value is within the range and within `min..=max`, which other settings
    /// determine.
    pub(crate) fn check_within(&self, value: f64, min: f64, max: f64) -> Result<f64, Error> {
        in_range(self.name, value, self.min.max(min), self.max.min(max))
    }
}
