//! Independent watchdog of the first stage, with a period of eight seconds. A page takes 22 ms, a
//! signature up to four seconds. RM0440 42.
//!
//! The watchdog keeps running when the image starts; the image then sets its own period. An image
//! that hangs before that is reset too.

use stm32_metapac::IWDG;
use stm32_metapac::iwdg::vals::{Key, Pr};

/// Starts the watchdog. IWDG_KR (42.4.1), PR (42.4.2), RLR (42.4.3), SR (42.4.4).
pub fn start() {
    IWDG.kr().write(|w| w.set_key(Key::START));
    IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    IWDG.pr().write(|w| w.set_pr(Pr::DIVIDE_BY64));
    IWDG.rlr().write(|w| w.set_rl(4095));
    while IWDG.sr().read().0 != 0 {}
    keep_alive();
}

/// Feeds the watchdog.
pub fn keep_alive() {
    IWDG.kr().write(|w| w.set_key(Key::RESET));
}
