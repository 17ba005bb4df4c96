//! User button B1 at PC13: a person at the board holds it to confirm an older version.
//!
//! The button is held if its level differs from that at the start, because descriptions of this
//! board disagree on the level.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::asm;
use stm32_metapac::GPIOC;
use stm32_metapac::gpio::vals::Pupdr;

use super::pins::Pin;

const BUTTON: Pin = Pin::new(GPIOC, 13);
/// Time for the pull-down to settle the level of an unconnected pin, 10 us in cycles of 170 MHz.
const SETTLE_CYCLES: u32 = 1700;
/// `true` if the released button reads as high.
static IS_RELEASED_HIGH: AtomicBool = AtomicBool::new(false);

/// Makes the pin an input, and reads the level of the released button.
pub fn start() {
    BUTTON.input(Pupdr::PULL_DOWN);
    asm::delay(SETTLE_CYCLES);
    IS_RELEASED_HIGH.store(BUTTON.is_high(), Ordering::Relaxed);
}

/// Returns `true` while the button is held.
pub fn is_held() -> bool {
    BUTTON.is_high() != IS_RELEASED_HIGH.load(Ordering::Relaxed)
}
