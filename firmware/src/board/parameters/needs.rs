//! Parameters that act only beside another one.
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
//! Without its encoder a belt that stands under the drive is welded: what depends on the last is refused without it, and it cannot be taken away from
//! what depends on it.

use crate::board::parameters::{PARAMETERS, Values, place_of};
use crate::seam::config::keys::{
    BELT_STOP, BURST_DUTY, BURST_PERIOD, DETENT_PITCH, ENERGY_PER_METRE, FORCE_HZ, FRICTION_ENABLED, METRE_PER_COUNT,
    NEWTON_PER_LSB, NTC_OHM, RESTRAINT_ENABLED, SHAPE, SUPPLY_DIVIDER, SWEEP_TIME,
};
use crate::seam::error::Error;
use crate::seam::features;
use crate::seam::refusal::Refusal;

/// Keys from the first to the second, and the one with which they act.
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

/// The key of the parameter without which the one with this key does not act.
pub fn need_of(key: u8) -> Option<u8> {
    NEEDS.iter().find(|(first, last, _)| (*first..=*last).contains(&key)).map(|(.., need)| *need)
}

/// Whether a value of the parameter at a place says that there is nothing of it.
pub fn is_idle(place: usize, value: f32) -> bool {
    match PARAMETERS[place].key {
        METRE_PER_COUNT | NEWTON_PER_LSB | NTC_OHM | SUPPLY_DIVIDER | ENERGY_PER_METRE => value.is_infinite(),
        _ => value == 0.0,
    }
}

/// Refuses a value that could not act beside the others of `values`, where `built_in` is built in. That is never refused.
pub(crate) fn check(place: usize, value: f32, values: &Values, built_in: &Values) -> Result<(), Refusal> {
    let key = PARAMETERS[place].key;
    if value == built_in[place] && !(key == METRE_PER_COUNT && is_idle(place, value)) {
        return Ok(());
    }
    let asks_for = match key {
        SHAPE | SWEEP_TIME if value != 0.0 => features::waveforms().map(drop),
        FRICTION_ENABLED | RESTRAINT_ENABLED if value != 0.0 => features::friction().map(drop),
        _ => Ok(()),
    };
    if let Err(Error::LeftOut { .. }) = asks_for {
        return Err(Refusal::LeftOut);
    }
    let is_there = |key: u8| place_of(key).is_ok_and(|place| !is_idle(place, values[place]));
    // To take something away never needs anything.
    let missing = need_of(key).is_some_and(|need| !is_there(need)) && !(is_flag_like(key) && is_idle(place, value));
    let needed = || [ENERGY_PER_METRE, RESTRAINT_ENABLED].into_iter().any(is_there);
    let taken_away = key == METRE_PER_COUNT && is_idle(place, value) && needed();
    if missing || taken_away { Err(Refusal::NotConfigured) } else { Ok(()) }
}

/// Whether the idle value of a parameter is the absence of a part.
fn is_flag_like(key: u8) -> bool {
    [ENERGY_PER_METRE, RESTRAINT_ENABLED].contains(&key)
}
