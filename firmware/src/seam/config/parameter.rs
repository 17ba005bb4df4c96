//! A setting that a host may set over the link, for the time after the next reset.

use crate::seam::config::Config;
use crate::seam::refusal::Refusal;

/// The key of `limits.energy_j_per_m`, which is a limit only where the belt has an encoder.
pub const ENERGY_PER_METRE: u8 = 14;

/// A number of the configuration.
#[derive(Clone, Copy)]
pub struct Parameter {
    /// Key of the parameter on the link and in the stored settings; never used again for another one.
    pub key: u8,
    /// Path of the setting in the configuration, with its unit.
    pub name: &'static str,
    /// Range of the values that the parameter may have.
    pub range: Range,
    /// Reads the parameter from a configuration.
    pub read: fn(&Config) -> f32,
    /// Writes the parameter into a configuration.
    pub write: fn(&mut Config, f32),
}

/// The values that a parameter may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// From the first to the second.
    Within(f32, f32),
    /// From the first to what is built in, and not beyond the second; what is built in may be infinity, which is no limit.
    UpToBuiltIn(f32, f32),
    /// What is built in, and a tenth more or less.
    NearBuiltIn,
}

/// How far a scale factor may be set from what is built in.
const NEAR: f32 = 0.1;

impl Range {
    /// The smallest and the largest value, where this is built in.
    pub fn of(self, built_in: f32) -> (f32, f32) {
        match self {
            Range::Within(least, most) => (least, most),
            Range::UpToBuiltIn(least, most) => (least, built_in.min(most)),
            Range::NearBuiltIn => (built_in * (1.0 - NEAR), built_in * (1.0 + NEAR)),
        }
    }
}

impl Parameter {
    /// Whether it is a limit: what is stored of it is never exceeded.
    pub fn is_limit(&self) -> bool {
        matches!(self.range, Range::UpToBuiltIn(..))
    }

    /// Refuses a value that it may not have, where `built_in` is built in. What is built in is never refused.
    pub fn check(&self, value: f32, built_in: f32) -> Result<(), Refusal> {
        let (least, most) = self.range.of(built_in);
        match value {
            _ if value.is_nan() => Err(Refusal::NotPlausible),
            _ if value == built_in || (least..=most).contains(&value) => Ok(()),
            _ => Err(Refusal::OutOfRange),
        }
    }
}
