//! The independent watchdog of the first stage: eight seconds, of which a page takes 22 ms and a signature up to four. RM0440 42.
//!
//! It goes on as the image starts, which takes it over with its own period: an image that hangs before that is ended, too.

use stm32_metapac::IWDG;
use stm32_metapac::iwdg::vals::{Key, Pr};

/// Starts it. IWDG_KR (42.4.1), PR (42.4.2), RLR (42.4.3), SR (42.4.4).
pub fn start() {
    IWDG.kr().write(|w| w.set_key(Key::START));
    IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    IWDG.pr().write(|w| w.set_pr(Pr::DIVIDE_BY64));
    IWDG.rlr().write(|w| w.set_rl(4095));
    while IWDG.sr().read().0 != 0 {}
    nurse();
}

/// Feeds it.
pub fn nurse() {
    IWDG.kr().write(|w| w.set_key(Key::RESET));
}
