//! Parameters: numbers of the configuration that a host may set, for the time after the next reset.
//!
//! Each has a key, which never changes its meaning, a name with its unit, and a range:
//!
//! | range | of | because |
//! |---|---|---|
//! | up to what is built in | limits | what a host sends can exceed none |
//! | within a tenth of what is built in | scale factors of the front end | limits are judged by what they measure |
//! | between two numbers | all others | |
//!
//! Whatever is set, the voltage and the current that the stack ends up with are thus within 11 % of what the image was built for (1 / 0.9), a power within
//! 23 %. That a configuration holds together (a drive within its limit, a band within the loop's) is for
//! [`build`](crate::controller::Controller::build) to say: see [`power_up`](crate::power_up).

use serde::{Deserialize, Serialize};

use crate::block::Amplitude;
use crate::config::{Config, LONGEST_PATIENCE_S, Schedule};
use crate::kept::Kept;
use crate::refusal::Refusal;

/// The most parameters that can be kept.
pub const MOST_PARAMETERS: usize = 24;

/// The key of `limits.energy_j_per_m`, which is a limit only where the belt has an encoder.
pub const ENERGY_PER_METRE: u8 = 14;

/// Parameters that differ from what is built in, by their keys.
pub type Overrides = heapless::Vec<(u8, f32), MOST_PARAMETERS>;

/// A value of each parameter, in the order of [`PARAMETERS`].
pub type Values = [f32; PARAMETERS.len()];

/// A number of the configuration.
pub struct Parameter {
    /// Its key.
    pub key: u8,
    /// Its place in the configuration, with its unit.
    pub name: &'static str,
    /// The values that it may have.
    pub range: Range,
    /// Reads it.
    pub read: fn(&Config) -> f32,
    /// Writes it.
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

/// One parameter, reported.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterReport {
    /// Its key.
    pub key: u8,
    /// What acts.
    pub acts: f32,
    /// What is set: acts after a reset, if it has been stored.
    pub next: f32,
    /// What is built in.
    pub built_in: f32,
    /// The smallest value that can be set.
    pub min: f32,
    /// The largest; infinity is none.
    pub max: f32,
    /// What is kept over power-off, of all settings.
    pub kept: Kept,
}

/// The place of a parameter in [`PARAMETERS`].
pub fn place_of(key: u8) -> Result<usize, Refusal> {
    PARAMETERS.iter().position(|parameter| parameter.key == key).ok_or(Refusal::NoSuchKey)
}

/// All parameters of a configuration.
pub fn values_of(config: &Config) -> Values {
    core::array::from_fn(|place| (PARAMETERS[place].read)(config))
}

/// Those that differ from what is built in.
pub fn overrides(values: &Values, built_in: &Values) -> Overrides {
    let differing = PARAMETERS.iter().zip(values.iter().zip(built_in)).filter(|(_, (value, built_in))| value != built_in);
    differing.map(|(parameter, (&value, _))| (parameter.key, value)).collect()
}

/// What is built in with overrides on top, and whether all of them could be used: one that nobody knows, or that is out of its range, is not.
///
/// A limit that is out of its range is the nearest that it can be, and one that cannot be read is the lowest: it is never what is built in
/// because something lower was stored.
pub fn overridden(overrides: &Overrides, built_in: &Values) -> (Values, bool) {
    let (mut values, mut all) = (*built_in, true);
    for &(key, value) in overrides {
        let Ok(place) = place_of(key) else {
            all = false;
            continue;
        };
        let parameter = &PARAMETERS[place];
        let usable = parameter.check(value, built_in[place]).is_ok();
        all &= usable;
        if parameter.is_limit() {
            let (least, most) = parameter.range.of(built_in[place]);
            // A not-a-number is below all.
            let nearest = if value > least { value.min(most) } else { least };
            // Of two that contradict each other the lower one.
            values[place] = values[place].min(if usable { value } else { nearest });
        } else if usable {
            values[place] = value;
        }
    }
    (values, all)
}

/// Writes what differs from what is built in into a configuration: those parameters whose places `acts` has.
pub fn apply(config: &mut Config, values: &Values, built_in: &Values, acts: impl Fn(usize) -> bool) {
    for (place, parameter) in PARAMETERS.iter().enumerate().filter(|(place, _)| acts(*place)) {
        if values[place] != built_in[place] {
            (parameter.write)(config, values[place]);
        }
    }
}

/// A limit that need not be: infinity is none.
fn limit(value: f32) -> Option<f32> {
    value.is_finite().then_some(value)
}

/// The ON part of a period, and the period in s; a drive that is always on has none.
fn periodic(config: &Config) -> (f64, f64) {
    match config.burst.schedule {
        Schedule::Periodic { period_s, duty } => (period_s, duty),
        Schedule::Continuous | Schedule::Windows(_) => (0.0, 1.0),
    }
}

/// The table. A key is never used again for something else.
pub static PARAMETERS: [Parameter; 21] = [
    Parameter {
        key: 1,
        name: "front_end.volt_per_lsb",
        range: Range::NearBuiltIn,
        read: |config| config.front_end.volt_per_lsb,
        write: |config, value| config.front_end.volt_per_lsb = value,
    },
    Parameter {
        key: 2,
        name: "front_end.ampere_per_lsb",
        range: Range::NearBuiltIn,
        read: |config| config.front_end.ampere_per_lsb,
        write: |config, value| config.front_end.ampere_per_lsb = value,
    },
    Parameter {
        key: 3,
        name: "front_end.drive_volt_per_lsb",
        range: Range::NearBuiltIn,
        read: |config| config.front_end.drive_volt_per_lsb,
        write: |config, value| config.front_end.drive_volt_per_lsb = value,
    },
    Parameter {
        key: 4,
        name: "drive.frequency_hz",
        range: Range::Within(1.0, 1e7),
        read: |config| config.drive.frequency_hz,
        write: |config, value| config.drive.frequency_hz = value,
    },
    // An amplitude is of one kind: zero is that it is of the other.
    Parameter {
        key: 5,
        name: "drive.amplitude_v",
        range: Range::Within(1e-3, 1e5),
        read: |config| if let Amplitude::Volts(volts) = config.drive.amplitude { volts } else { 0.0 },
        write: |config, value| config.drive.amplitude = Amplitude::Volts(value),
    },
    Parameter {
        key: 6,
        name: "drive.motional_current_a",
        range: Range::Within(1e-6, 1e4),
        read: |config| if let Amplitude::MotionalCurrent(amperes) = config.drive.amplitude { amperes } else { 0.0 },
        write: |config, value| config.drive.amplitude = Amplitude::MotionalCurrent(value),
    },
    Parameter {
        key: 7,
        name: "drive.scan_volts",
        range: Range::Within(1e-3, 1e5),
        read: |config| config.drive.scan_volts,
        write: |config, value| config.drive.scan_volts = value,
    },
    Parameter {
        key: 8,
        name: "limits.voltage_v",
        range: Range::UpToBuiltIn(1e-3, f32::INFINITY),
        read: |config| config.limits.voltage_v,
        write: |config, value| config.limits.voltage_v = value,
    },
    Parameter {
        key: 9,
        name: "limits.current_a",
        range: Range::UpToBuiltIn(1e-6, f32::INFINITY),
        read: |config| config.limits.current_a,
        write: |config, value| config.limits.current_a = value,
    },
    Parameter {
        key: 10,
        name: "limits.power_w",
        range: Range::UpToBuiltIn(1e-3, 1e5),
        read: |config| config.limits.power_w.unwrap_or(f32::INFINITY),
        write: |config, value| config.limits.power_w = limit(value),
    },
    Parameter {
        key: 11,
        name: "limits.temperature_c",
        range: Range::UpToBuiltIn(0.0, f32::INFINITY),
        read: |config| config.limits.temperature_c,
        write: |config, value| config.limits.temperature_c = value,
    },
    Parameter {
        key: 12,
        name: "limits.on_time_s",
        range: Range::UpToBuiltIn(1e-3, 3e4),
        read: |config| config.limits.on_time_s.unwrap_or(f32::INFINITY),
        write: |config, value| config.limits.on_time_s = limit(value),
    },
    Parameter {
        key: 13,
        name: "limits.belt_stop_ms",
        range: Range::UpToBuiltIn(0.1, f32::INFINITY),
        read: |config| config.limits.belt_stop_ms,
        write: |config, value| config.limits.belt_stop_ms = value,
    },
    Parameter {
        key: ENERGY_PER_METRE,
        name: "limits.energy_j_per_m",
        range: Range::UpToBuiltIn(1e-3, 1e9),
        read: |config| config.limits.energy_j_per_m.unwrap_or(f32::INFINITY),
        write: |config, value| config.limits.energy_j_per_m = limit(value),
    },
    Parameter {
        key: 15,
        name: "tracking.nominal_q",
        range: Range::Within(2.0, 1e5),
        read: |config| config.tracking.nominal_q,
        write: |config, value| config.tracking.nominal_q = value,
    },
    Parameter {
        key: 16,
        name: "tracking.nominal_c0_f",
        range: Range::Within(1e-12, 1e-3),
        read: |config| config.tracking.nominal_c0_f,
        write: |config, value| config.tracking.nominal_c0_f = value,
    },
    Parameter {
        key: 17,
        name: "tracking.span",
        range: Range::Within(1e-4, 0.2),
        read: |config| config.tracking.span,
        write: |config, value| config.tracking.span = value,
    },
    Parameter {
        key: 18,
        name: "tracking.bandwidth_hz",
        range: Range::Within(0.1, 1e6),
        read: |config| config.tracking.bandwidth_hz,
        write: |config, value| config.tracking.bandwidth_hz = value,
    },
    // A period of zero is a drive that is always on; the duty is of a period only, and comes after it.
    Parameter {
        key: 19,
        name: "burst.period_s",
        range: Range::Within(0.0, 1e3),
        read: |config| periodic(config).0 as f32,
        write: |config, value| {
            config.burst.schedule = match periodic(config) {
                _ if value == 0.0 => Schedule::Continuous,
                (_, duty) => Schedule::Periodic { period_s: value.into(), duty },
            }
        },
    },
    Parameter {
        key: 20,
        name: "burst.duty",
        range: Range::Within(0.0, 1.0),
        read: |config| periodic(config).1 as f32,
        write: |config, value| {
            if let Schedule::Periodic { duty, .. } = &mut config.burst.schedule {
                *duty = value.into();
            }
        },
    },
    Parameter {
        key: 21,
        name: "link.patience_s",
        range: Range::Within(0.0, LONGEST_PATIENCE_S),
        read: |config| config.link.patience_s,
        write: |config, value| config.link.patience_s = value,
    },
];

#[cfg(test)]
pub(crate) mod tests;
