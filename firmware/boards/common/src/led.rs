//! The status LED: what the board does, and the number of a fault, in flashes.
//!
//! | board | LED |
//! |---|---|
//! | idle | a flash of 50 ms every 2 s |
//! | drives | on |
//! | in a fault | its number: a long flash for each ten, a short one for each unit, and a pause of 1.2 s; fault 21 is long, long, short |

use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;

/// Time that a flash takes, and the part of it that is lit, ms.
const LONG: (u32, u32) = (700, 500);
const SHORT: (u32, u32) = (300, 100);
/// From the last unit to the first ten, ms.
const PAUSE: u32 = 1200;
/// A sign of life: the same, ms.
const IDLE: (u32, u32) = (2000, 50);

/// Whether the LED is lit so many milliseconds after any moment, for a mode and a fault.
#[inline]
pub fn is_lit(mode: Mode, fault: Option<Fault>, milliseconds: u32) -> bool {
    match (mode, fault) {
        (_, Some(fault)) => flashes(fault.code(), milliseconds),
        (Mode::Idle | Mode::Fault, None) => lights(IDLE, milliseconds % IDLE.0),
        _ => true,
    }
}

/// Whether the number is lit at a moment.
fn flashes(code: u8, milliseconds: u32) -> bool {
    let (tens, units) = (u32::from(code / 10), u32::from(code % 10));
    let at = milliseconds % (tens * LONG.0 + units * SHORT.0 + PAUSE);
    match at.checked_sub(tens * LONG.0) {
        None => lights(LONG, at % LONG.0),
        Some(at) => at < units * SHORT.0 && lights(SHORT, at % SHORT.0),
    }
}

fn lights((_, lit): (u32, u32), at: u32) -> bool {
    at < lit
}
