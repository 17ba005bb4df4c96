//! How high a limit can be set.
//!
//! A limit of voltage, current or power is judged by the codes of converters, and a scale factor says what a code is worth. The ceiling of a limit is as many
//! codes as what is built in:
//!
//! ```text
//! ceiling = limit built in * product of (scale factor / scale factor built in)
//! ```
//!
//! At a D-ring the belt stands until the crash, and the drive locks over it once: where a restraint is enabled, `limits.belt_stop_ms` can be set as high as
//! [`AT_D_RING_MS`], and falls back with it.
//!
//! A front end that is said to be worth more lets limits rise in volts and amperes, and never in codes: the analog trip, which knows only codes, and the limits
//! keep their order.

use crate::board::parameters::{PARAMETERS, Values, place_of};
use crate::seam::config::keys::{BELT_STOP, RESTRAINT_ENABLED};

/// How long the drive may stay ON over a belt that stands where it is that of a D-ring, ms.
pub const AT_D_RING_MS: f32 = 1000.0;

/// Keys of the limits that are judged by converters, and of the scale factors by which they are.
const JUDGED_BY: [(u8, &[u8]); 4] = [
    (VOLTAGE_LIMIT, &[VOLT_OF_DRIVE]),
    (CURRENT_LIMIT, &[AMPERE]),
    (POWER_LIMIT, &[VOLT, AMPERE]),
    (crate::seam::config::keys::ENERGY_PER_METRE, &[VOLT, AMPERE]),
];

const VOLT: u8 = 1;
const AMPERE: u8 = 2;
const VOLT_OF_DRIVE: u8 = 3;
const VOLTAGE_LIMIT: u8 = 8;
const CURRENT_LIMIT: u8 = 9;
const POWER_LIMIT: u8 = 10;

/// The largest value of the parameter at a place, with the scale factors of `values`; what is built in where nothing scales it.
pub fn ceiling(place: usize, values: &Values, built_in: &Values) -> f32 {
    let key = PARAMETERS[place].key;
    let restrains = place_of(RESTRAINT_ENABLED).is_ok_and(|place| values[place] != 0.0);
    if key == BELT_STOP && restrains {
        return built_in[place].max(AT_D_RING_MS);
    }
    let scales = JUDGED_BY.iter().filter(|(limit, _)| *limit == key).flat_map(|(_, scales)| *scales);
    scales.fold(built_in[place], |ceiling, &scale| match place_of(scale) {
        // Alike, it is what is built in to the last bit.
        Ok(scale) if values[scale] != built_in[scale] => ceiling * (values[scale] / built_in[scale]),
        _ => ceiling,
    })
}
