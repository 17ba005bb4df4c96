//! The independent watchdog: resets the part unless it is fed within 10 ms, by its own oscillator. RM0440 42.
//!
//! It is fed by the background task, and only while blocks come ([`App`](firmware::board::app::App)). What makes the background task wait (the flash) feeds it
//! meanwhile, and only while blocks come, too: [`nurse`].

use core::sync::atomic::{AtomicU32, Ordering};

use boards_common::note::Cause;
use firmware::board::app::Watchdog;
use stm32_metapac::iwdg::vals::{Key, Pr};
use stm32_metapac::{DBGMCU, IWDG};

use super::{count, panic};

/// Ticks of 125 us (LSI 32 kHz / 4, within 5 %: DS12288) until it resets the part: 10 ms.
const TICKS: u16 = 80;

/// The blocks at the last call of [`nurse`] that fed it.
static SEEN: AtomicU32 = AtomicU32::new(0);

/// The watchdog.
pub struct IndependentWatchdog;

impl IndependentWatchdog {
    /// Starts it; nothing but a reset stops it. IWDG_KR (42.4.1), PR (42.4.2), RLR (42.4.3), SR (42.4.4).
    pub fn start() -> Self {
        // DBGMCU_APB1FZR1 (47.6.5): it waits while a debugger has halted the processor. The enable drops then by TIM1 (`protection.rs`).
        DBGMCU.apb1lfzr().modify(|w| w.set_iwdg(true));
        IWDG.kr().write(|w| w.set_key(Key::START));
        IWDG.kr().write(|w| w.set_key(Key::ENABLE));
        IWDG.pr().write(|w| w.set_pr(Pr::DIVIDE_BY4));
        IWDG.rlr().write(|w| w.set_rl(TICKS - 1));
        while IWDG.sr().read().0 != 0 {}
        let mut dog = IndependentWatchdog;
        dog.feed();
        dog
    }
}

impl Watchdog for IndependentWatchdog {
    fn feed(&mut self) {
        IWDG.kr().write(|w| w.set_key(Key::RESET));
    }

    fn reset(&mut self) {
        panic::end(Cause::Ordered, "", 0);
    }
}

/// Lets it wait for eight seconds, while the background task checks an update; blocks go on. Only in silence, with the amplifier off.
#[cfg(feature = "slot")]
pub fn relax() {
    set_period(Pr::DIVIDE_BY64, 4096);
}

/// Takes it back to its period.
#[cfg(feature = "slot")]
pub fn tighten() {
    set_period(Pr::DIVIDE_BY4, TICKS);
}

/// Sets prescaler and ticks, and feeds it: IWDG_KR, PR, RLR, SR (42.4).
#[cfg(feature = "slot")]
fn set_period(prescaler: Pr, ticks: u16) {
    IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    IWDG.pr().write(|w| w.set_pr(prescaler));
    IWDG.rlr().write(|w| w.set_rl(ticks - 1));
    while IWDG.sr().read().0 != 0 {}
    IWDG.kr().write(|w| w.set_key(Key::RESET));
}

/// Feeds it if a block has come since the last time.
pub fn nurse() {
    let blocks = count::blocks();
    if SEEN.swap(blocks, Ordering::Relaxed) != blocks {
        IWDG.kr().write(|w| w.set_key(Key::RESET));
    }
}
