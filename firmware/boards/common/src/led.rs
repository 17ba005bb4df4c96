//! Status LED: it shows the state of the board, and the number of a fault as flashes.
//!
//! | board | LED |
//! |---|---|
//! | idle | a flash of 50 ms every 2 s |
//! | drives | on |
//! | in a fault | its number: a long flash for each ten, a short one for each unit, then a pause of 1.2 s; fault 21 is long, long, short |

use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;

/// Period of a long flash, for each ten, ms.
const LONG_PERIOD_MS: u32 = 700;
/// Lit time of a long flash, ms.
const LONG_LIT_MS: u32 = 500;
/// Period of a short flash, for each unit, ms.
const SHORT_PERIOD_MS: u32 = 300;
/// Lit time of a short flash, ms.
const SHORT_LIT_MS: u32 = 100;
/// Pause between the last unit and the first ten, ms.
const PAUSE_MS: u32 = 1200;
/// Period of the flash of an idle board, ms.
const IDLE_PERIOD_MS: u32 = 2000;
/// Lit time of the flash of an idle board, ms.
const IDLE_LIT_MS: u32 = 50;

/// Returns `true` if the LED is lit at a time, ms from any fixed moment, for a mode and a fault.
#[inline]
pub fn is_lit(mode: Mode, fault: Option<Fault>, milliseconds: u32) -> bool {
    match (mode, fault) {
        (_, Some(fault)) => flashes(fault.code(), milliseconds),
        (Mode::Idle | Mode::Fault, None) => milliseconds % IDLE_PERIOD_MS < IDLE_LIT_MS,
        _ => true,
    }
}

/// Returns `true` if the flashes of a fault's number are lit at a time, ms.
fn flashes(code: u8, milliseconds: u32) -> bool {
    let (tens, units) = (u32::from(code / 10), u32::from(code % 10));
    let long_ms = tens * LONG_PERIOD_MS;
    let at = milliseconds % (long_ms + units * SHORT_PERIOD_MS + PAUSE_MS);
    match at.checked_sub(long_ms) {
        None => at % LONG_PERIOD_MS < LONG_LIT_MS,
        Some(at) => at < units * SHORT_PERIOD_MS && at % SHORT_PERIOD_MS < SHORT_LIT_MS,
    }
}
