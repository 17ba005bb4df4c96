//! Parameters: settings that a host may set over the link, effective after the next reset.

use crate::seam::config::Config;
use crate::seam::refusal::Refusal;

/// Keys of parameters that are related to others.
pub mod keys {
    /// `limits.belt_stop_ms`.
    pub const BELT_STOP: u8 = 13;
    /// `limits.energy_j_per_m`.
    pub const ENERGY_PER_METRE: u8 = 14;
    /// `burst.period_s`.
    pub const BURST_PERIOD: u8 = 19;
    /// `burst.duty`.
    pub const BURST_DUTY: u8 = 20;
    /// `front_end.metre_per_count`.
    pub const METRE_PER_COUNT: u8 = 56;
    /// `front_end.newton_per_lsb`.
    pub const NEWTON_PER_LSB: u8 = 57;
    /// `front_end.force_hz`.
    pub const FORCE_HZ: u8 = 58;
    /// `heat_sink.ohm_at_25_c`.
    pub const NTC_OHM: u8 = 59;
    /// `supply.divider`.
    pub const SUPPLY_DIVIDER: u8 = 93;
    /// `drive.shape`.
    pub const SHAPE: u8 = 64;
    /// `sweep.time_s`.
    pub const SWEEP_TIME: u8 = 68;
    /// `friction.enabled`.
    pub const FRICTION_ENABLED: u8 = 74;
    /// `friction.detent_pitch_m`.
    pub const DETENT_PITCH: u8 = 96;
    /// `restraint.enabled`.
    pub const RESTRAINT_ENABLED: u8 = 83;
}

/// Numeric setting of the configuration.
#[derive(Clone, Copy)]
pub struct Parameter {
    /// Key of the parameter on the link and in the stored settings; never reused for another one.
    pub key: u8,
    /// Path of the setting in the configuration, with its unit.
    pub name: &'static str,
    /// Range of allowed values.
    pub range: Range,
    /// Reads the parameter from a configuration.
    pub read: fn(&Config) -> f32,
    /// Writes the parameter into a configuration.
    pub write: fn(&mut Config, f32),
}

/// Optional table of a configuration.
pub(crate) trait Optional: Sized + 'static {
    /// Values of the parameters if the table is absent.
    const DEFAULT: Self;

    /// Returns the table of a configuration.
    fn of(config: &Config) -> Option<&Self>;

    /// Returns the table of a configuration, to be changed.
    fn of_mut(config: &mut Config) -> Option<&mut Self>;
}

/// Range of allowed values of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// From the first value to the second.
    Within(f32, f32),
    /// A scale factor of the front end, from the first value to the second. It also scales the
    /// ceilings of the limits that depend on it.
    Scale(f32, f32),
    /// A limit, from the first value to its ceiling, but not beyond the second. An infinite ceiling
    /// means no limit.
    UpToCeiling(f32, f32),
    /// One of these names, by its index.
    Choice(&'static [&'static str]),
    /// A whole number from the first value to the second.
    Whole(u8, u8),
}

impl Range {
    /// Returns the smallest and the largest value. `ceiling` applies to a limit.
    pub fn of(self, ceiling: f32) -> (f32, f32) {
        match self {
            Range::Within(least, most) | Range::Scale(least, most) => (least, most),
            Range::UpToCeiling(least, most) => (least, ceiling.min(most)),
            Range::Choice(names) => (0.0, names.len() as f32 - 1.0),
            Range::Whole(least, most) => (least.into(), most.into()),
        }
    }
}

/// Setting with a few values, which have names in a scene and indices on the link.
pub(crate) trait Choice: Copy + PartialEq + 'static {
    /// All values.
    const ALL: &'static [Self];
    /// Names of the values in a scene.
    const NAMES: &'static [&'static str];

    /// Returns the index of this value.
    fn place(self) -> f32 {
        Self::ALL.iter().position(|choice| *choice == self).unwrap_or(0) as f32
    }

    /// Returns the value at an index; the first value if the index is out of range.
    fn at(place: f32) -> Self {
        Self::ALL.get(place as usize).copied().unwrap_or(Self::ALL[0])
    }
}

impl Choice for bool {
    const ALL: &'static [Self] = &[false, true];
    const NAMES: &'static [&'static str] = &["false", "true"];
}

impl Parameter {
    /// Creates a parameter that is true or false.
    pub(crate) const fn flag(key: u8, name: &'static str, read: fn(&Config) -> f32, write: fn(&mut Config, f32)) -> Self {
        Parameter { key, name, range: Range::Choice(<bool as Choice>::NAMES), read, write }
    }

    /// Returns `true` if the parameter is a limit: the stored value is never exceeded.
    pub fn is_limit(&self) -> bool {
        matches!(self.range, Range::UpToCeiling(..))
    }

    /// Checks that a value is allowed. `built_in` is the built-in value, or the ceiling of a limit;
    /// it is always allowed.
    pub fn check(&self, value: f32, built_in: f32) -> Result<(), Refusal> {
        let (least, most) = self.range.of(built_in);
        let is_whole = !matches!(self.range, Range::Choice(_) | Range::Whole(..)) || value == libm::truncf(value);
        match value {
            _ if value.is_nan() => Err(Refusal::NotPlausible),
            _ if value == built_in || (least..=most).contains(&value) && is_whole => Ok(()),
            _ => Err(Refusal::OutOfRange),
        }
    }
}
