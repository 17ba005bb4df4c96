//! Option bytes: read at start, never written here. [`nucleo_g474re::options`] lists the required
//! values.

use nucleo_g474re::options::{mismatches, names};
use stm32_metapac::FLASH;

/// Returns the options with a wrong value, one bit each, and logs their names.
pub fn check() -> u16 {
    let wrong = mismatches(FLASH.optr().read().0, FLASH.wrp1ar().read().0, cfg!(feature = "slot"));
    for name in names(wrong) {
        defmt::warn!("option byte {=str} has a wrong value (docs/board.md)", name);
    }
    wrong
}
