//! Ceilings: the largest values that limits can be set to.
//!
//! A limit of voltage, current or power is checked in converter codes, and a scale factor gives the
//! value of a code. The ceiling of a limit is the number of codes of the built-in limit:
//!
//! ```text
//! ceiling = built-in limit * product of (scale factor / built-in scale factor)
//! ```
//!
//! At a D-ring the belt does not move until the crash, and the drive locks over it once. With a
//! restraint enabled, `limits.belt_stop_ms` can therefore be set up to [`AT_D_RING_MS`]; without
//! it, the limit falls back.
//!
//! Larger scale factors let limits rise in volts and amperes, but never in codes. The limits
//! therefore keep their order relative to the analog trip, which acts on codes.

use crate::board::parameters::{PARAMETERS, Values, place_of};
use crate::seam::config::keys::{BELT_STOP, RESTRAINT_ENABLED};

/// Longest time that the drive may stay ON over the standing belt of a D-ring, ms.
pub const AT_D_RING_MS: f32 = 1000.0;

/// Keys of the limits that are checked in converter codes, with the keys of their scale factors.
const SCALED_LIMITS: [(u8, &[u8]); 4] = [
    (VOLTAGE_LIMIT_KEY, &[DRIVE_VOLT_PER_LSB_KEY]),
    (CURRENT_LIMIT_KEY, &[AMPERE_PER_LSB_KEY]),
    (POWER_LIMIT_KEY, &[VOLT_PER_LSB_KEY, AMPERE_PER_LSB_KEY]),
    (crate::seam::config::keys::ENERGY_PER_METRE, &[VOLT_PER_LSB_KEY, AMPERE_PER_LSB_KEY]),
];

const VOLT_PER_LSB_KEY: u8 = 1;
const AMPERE_PER_LSB_KEY: u8 = 2;
const DRIVE_VOLT_PER_LSB_KEY: u8 = 3;
const VOLTAGE_LIMIT_KEY: u8 = 8;
const CURRENT_LIMIT_KEY: u8 = 9;
const POWER_LIMIT_KEY: u8 = 10;

/// Returns the largest value of the parameter at a place, with the scale factors of `values`; the
/// built-in value if nothing scales it.
pub fn ceiling(place: usize, values: &Values, built_in: &Values) -> f32 {
    let key = PARAMETERS[place].key;
    let restrains = place_of(RESTRAINT_ENABLED).is_ok_and(|place| values[place] != 0.0);
    if key == BELT_STOP && restrains {
        return built_in[place].max(AT_D_RING_MS);
    }
    let scales = SCALED_LIMITS.iter().filter(|(limit, _)| *limit == key).flat_map(|(_, scales)| *scales);
    scales.fold(built_in[place], |ceiling, &scale| match place_of(scale) {
        // Equal scale factors leave the built-in value as it is, to the last bit.
        Ok(scale) if values[scale] != built_in[scale] => ceiling * (values[scale] / built_in[scale]),
        _ => ceiling,
    })
}
