//! The option bytes: read at start, never written here. [`nucleo_g474re::options`] says what they should be.

use nucleo_g474re::options::{mismatches, names};
use stm32_metapac::FLASH;

/// The options that are not as they should be, one bit each; the log names them.
pub fn look() -> u16 {
    let wrong = mismatches(FLASH.optr().read().0, FLASH.wrp1ar().read().0, cfg!(feature = "slot"));
    for name in names(wrong) {
        defmt::warn!("option byte {=str} is not as it should be (docs/board.md)", name);
    }
    wrong
}
