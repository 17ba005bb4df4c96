//! Parameters: numbers of the configuration that a host may set, and that act after the next reset.
//!
//! Every setting with a key in its table in [`config`](crate::seam::config) is a parameter. It has
//! a key, whose meaning never changes, a name with its unit, and a range:
//!
//! | range | parameters | reason |
//! |---|---|---|
//! | up to a [`ceiling`] | limits | a host cannot raise a limit |
//! | between two numbers | scale factors of the front end | the ceilings of limits that are checked with them follow them |
//! | between two numbers, or one of a list | all others | |
//!
//! Some parameters act only with another one ([`need_of`]). A value that could not act is refused
//! when it is set.
//!
//! Therefore no set value makes the converters play or accept a code beyond the limits of the
//! image. [`build`](crate::controller::Controller::build) checks that a configuration is consistent
//! (a drive within its limit, a band within that of the loop): see
//! [`power_up`](crate::board::power_up).

mod ceilings;
mod needs;

use serde::{Deserialize, Serialize};

pub use crate::board::parameters::ceilings::{AT_D_RING_MS, ceiling};
pub(crate) use crate::board::parameters::needs::check as check_need;
pub use crate::board::parameters::needs::{is_idle, need_of};
use crate::board::stored_state::StoredState;
use crate::seam::config::{
    Burst, Chirp, Config, Drive, Friction, FrontEnd, HeatSink, Limits, Link, Parameter, Phasing, Restraint, Supply, Thermometer,
    Tracking,
};
use crate::seam::refusal::Refusal;

/// Largest number of parameters that can be stored.
pub(crate) const MAX_PARAMETERS: usize = 93;

/// Parameters that differ from their defaults, by their keys.
pub type Overrides = heapless::Vec<(u8, f32), MAX_PARAMETERS>;

/// Values of all parameters, in the order of [`PARAMETERS`].
pub type Values = [f32; PARAMETERS.len()];

/// Report of one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterReport {
    /// Key of the parameter.
    pub key: u8,
    /// Active value, since the last reset.
    pub acts: f32,
    /// Set value: active after a reset, if it has been stored.
    pub next: f32,
    /// Default: the value of the image.
    pub built_in: f32,
    /// Smallest value that can be set.
    pub min: f32,
    /// Largest value that can be set; infinity if unlimited.
    pub max: f32,
    /// State of the stored settings as a whole.
    pub stored: StoredState,
}

/// Returns the place of a parameter in [`PARAMETERS`].
pub(crate) fn place_of(key: u8) -> Result<usize, Refusal> {
    PARAMETERS.iter().position(|parameter| parameter.key == key).ok_or(Refusal::NoSuchKey)
}

/// Returns the values of all parameters in a configuration.
pub fn values_of(config: &Config) -> Values {
    core::array::from_fn(|place| (PARAMETERS[place].read)(config))
}

/// Returns the values that differ from the built-in ones.
pub(crate) fn overrides(values: &Values, built_in: &Values) -> Overrides {
    let differing = PARAMETERS.iter().zip(values.iter().zip(built_in)).filter(|(_, (value, built_in))| value != built_in);
    differing.map(|(parameter, (&value, _))| (parameter.key, value)).collect()
}

/// Returns the built-in values with overrides applied, and `true` if all overrides could be used.
/// An unknown override, or one out of its range, is not used.
///
/// A limit out of its range becomes the nearest valid value, and NaN the lowest one. A stored lower
/// limit is therefore never replaced by the built-in one.
pub(crate) fn overridden(overrides: &Overrides, built_in: &Values) -> (Values, bool) {
    let (mut values, mut all) = (*built_in, true);
    for &(key, value) in overrides {
        let Ok(place) = place_of(key) else {
            all = false;
            continue;
        };
        if PARAMETERS[place].is_limit() {
            continue;
        }
        let usable = PARAMETERS[place].check(value, built_in[place]).is_ok();
        all &= usable;
        if usable {
            values[place] = value;
        }
    }
    // Limits come after the scale factors that their ceilings follow. They start at infinity, so
    // that of two contradictory entries the lower one acts.
    let limits =
        || overrides.iter().filter_map(|&(key, value)| Some((place_of(key).ok()?, value))).filter(|(place, _)| is_limit(*place));
    for (place, _) in limits() {
        values[place] = f32::INFINITY;
    }
    for (place, value) in limits() {
        let (parameter, ceiling) = (&PARAMETERS[place], ceiling(place, &values, built_in));
        let usable = parameter.check(value, ceiling).is_ok();
        all &= usable;
        let (least, most) = parameter.range.of(ceiling);
        // NaN gives `least`. So does a ceiling below it, and then the configuration does not build.
        let nearest = if value > least { value.min(most).max(least) } else { least };
        values[place] = values[place].min(if usable { value } else { nearest });
    }
    (values, all)
}

fn is_limit(place: usize) -> bool {
    PARAMETERS[place].is_limit()
}

/// Writes the values that differ from the built-in ones into a configuration, for the parameters
/// whose place satisfies `acts`. Holds each limit to its ceiling.
pub fn apply(config: &mut Config, values: &Values, built_in: &Values, acts: impl Fn(usize) -> bool) {
    let mut acting: Values = core::array::from_fn(|place| if acts(place) { values[place] } else { built_in[place] });
    for place in (0..PARAMETERS.len()).filter(|&place| is_limit(place)) {
        acting[place] = acting[place].min(ceiling(place, &acting, built_in));
    }
    for (place, parameter) in PARAMETERS.iter().enumerate() {
        if acting[place] != built_in[place] {
            (parameter.write)(config, acting[place]);
        }
    }
}

/// Tables of the settings that are parameters.
const TABLES: &[&[Parameter]] = &[
    FrontEnd::PARAMETERS,
    Drive::PARAMETERS,
    Drive::OTHERS,
    Limits::PARAMETERS,
    Tracking::PARAMETERS,
    Burst::PERIOD,
    Burst::PARAMETERS,
    Burst::WINDOWS,
    Thermometer::PARAMETERS,
    Link::PARAMETERS,
    HeatSink::PARAMETERS,
    Supply::PARAMETERS,
    Config::PARAMETERS,
    Phasing::PARAMETERS,
    Chirp::TIME,
    Chirp::PARAMETERS,
    Friction::OTHERS,
    Friction::PARAMETERS,
    Restraint::PARAMETERS,
];

const COUNT: usize = {
    let (mut count, mut table) = (0, 0);
    while table < TABLES.len() {
        count += TABLES[table].len();
        table += 1;
    }
    assert!(count <= MAX_PARAMETERS);
    count
};

/// All parameters, by rising key. A key is never used again for something else.
pub static PARAMETERS: [Parameter; COUNT] = by_key();

/// Returns the parameters of all tables, sorted by key.
const fn by_key() -> [Parameter; COUNT] {
    let mut all = [TABLES[0][0]; COUNT];
    let (mut count, mut table) = (0, 0);
    while table < TABLES.len() {
        let mut entry = 0;
        while entry < TABLES[table].len() {
            let parameter = TABLES[table][entry];
            let mut place = count;
            while place > 0 && all[place - 1].key > parameter.key {
                all[place] = all[place - 1];
                place -= 1;
            }
            all[place] = parameter;
            count += 1;
            entry += 1;
        }
        table += 1;
    }
    all
}

#[cfg(test)]
pub(crate) mod tests;
