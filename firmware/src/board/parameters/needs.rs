//! Parameters that act only with another one.
//!
//! | parameters | act with |
//! |---|---|
//! | `friction.*` | `friction.enabled` |
//! | `restraint.*` | `restraint.enabled` |
//! | `sweep.*` | `sweep.time_s` |
//! | `burst.duty` | `burst.period_s` |
//! | `heat_sink.*` | `heat_sink.ohm_at_25_c` |
//! | `supply.*` | `supply.divider` |
//! | `front_end.force_hz` | `front_end.newton_per_lsb` |
//! | `limits.belt_stop_ms`, `limits.energy_j_per_m`, `restraint.enabled` | `front_end.metre_per_count` |
//!
//! Without an encoder, a belt that stands still under the drive could be welded. The parameters of
//! the last row are therefore refused without the scale of the encoder, and the scale cannot be
//! removed while one of them needs it.

use crate::board::parameters::{PARAMETERS, Values, place_of};
use crate::seam::config::keys::{
    BELT_STOP, BURST_DUTY, BURST_PERIOD, DETENT_PITCH, ENERGY_PER_METRE, FORCE_HZ, FRICTION_ENABLED, METRE_PER_COUNT,
    NEWTON_PER_LSB, NTC_OHM, RESTRAINT_ENABLED, SHAPE, SUPPLY_DIVIDER, SWEEP_TIME,
};
use crate::seam::error::Error;
use crate::seam::features;
use crate::seam::refusal::Refusal;

/// First and last key of a range, and the key of the parameter that the range needs.
const NEEDS: [(u8, u8, u8); 10] = [
    (BELT_STOP, ENERGY_PER_METRE, METRE_PER_COUNT),
    (RESTRAINT_ENABLED, RESTRAINT_ENABLED, METRE_PER_COUNT),
    (BURST_DUTY, BURST_DUTY, BURST_PERIOD),
    (FORCE_HZ, FORCE_HZ, NEWTON_PER_LSB),
    (NTC_OHM + 1, NTC_OHM + 2, NTC_OHM),
    (SUPPLY_DIVIDER + 1, SUPPLY_DIVIDER + 2, SUPPLY_DIVIDER),
    (SWEEP_TIME + 1, FRICTION_ENABLED - 1, SWEEP_TIME),
    (FRICTION_ENABLED + 1, RESTRAINT_ENABLED - 1, FRICTION_ENABLED),
    (DETENT_PITCH, DETENT_PITCH + 1, FRICTION_ENABLED),
    (RESTRAINT_ENABLED + 1, RESTRAINT_ENABLED + 7, RESTRAINT_ENABLED),
];

/// Returns the key of the parameter without which the one with this key does not act.
pub fn need_of(key: u8) -> Option<u8> {
    NEEDS.iter().find(|(first, last, _)| (*first..=*last).contains(&key)).map(|(.., need)| *need)
}

/// Returns `true` if this value of the parameter at a place means "off" or "not present".
pub fn is_idle(place: usize, value: f32) -> bool {
    match PARAMETERS[place].key {
        METRE_PER_COUNT | NEWTON_PER_LSB | NTC_OHM | SUPPLY_DIVIDER | ENERGY_PER_METRE => value.is_infinite(),
        _ => value == 0.0,
    }
}

/// Refuses a value that could not act with the other `values`. The built-in value is never refused,
/// except for a missing belt scale that another parameter needs.
pub(crate) fn check(place: usize, value: f32, values: &Values, built_in: &Values) -> Result<(), Refusal> {
    let key = PARAMETERS[place].key;
    if value == built_in[place] && !(key == METRE_PER_COUNT && is_idle(place, value)) {
        return Ok(());
    }
    let feature = match key {
        SHAPE | SWEEP_TIME if value != 0.0 => features::waveforms().map(drop),
        FRICTION_ENABLED | RESTRAINT_ENABLED if value != 0.0 => features::friction().map(drop),
        _ => Ok(()),
    };
    if let Err(Error::LeftOut { .. }) = feature {
        return Err(Refusal::LeftOut);
    }
    let is_there = |key: u8| place_of(key).is_ok_and(|place| !is_idle(place, values[place]));
    // Removing a part never needs anything.
    let missing = need_of(key).is_some_and(|need| !is_there(need)) && !(is_flag_like(key) && is_idle(place, value));
    let needed = || [ENERGY_PER_METRE, RESTRAINT_ENABLED].into_iter().any(is_there);
    let taken_away = key == METRE_PER_COUNT && is_idle(place, value) && needed();
    if missing || taken_away { Err(Refusal::NotConfigured) } else { Ok(()) }
}

/// Returns `true` if the idle value of a parameter means that its part is not present.
fn is_flag_like(key: u8) -> bool {
    [ENERGY_PER_METRE, RESTRAINT_ENABLED].contains(&key)
}
