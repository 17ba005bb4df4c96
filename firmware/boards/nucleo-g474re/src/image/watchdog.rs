//! Independent watchdog: it has its own oscillator and resets the processor unless it is fed within
//! 10 ms. RM0440 42.
//!
//! The background task feeds it, but only while blocks are served
//! ([`App`](firmware::board::app::App)). Flash operations, during which the background task waits,
//! feed it too, under the same condition: [`keep_alive`].

use core::sync::atomic::{AtomicU32, Ordering};

use boards_common::note::Cause;
use firmware::board::app::Watchdog;
use stm32_metapac::iwdg::vals::{Key, Pr};
use stm32_metapac::{DBGMCU, IWDG};

use super::{count, panic};

/// Period in ticks of 125 us (LSI 32 kHz / 4, within 5 %: DS12288): 10 ms.
const PERIOD_TICKS: u16 = 80;

/// Block count at the last call of [`keep_alive`].
static LAST_BLOCK: AtomicU32 = AtomicU32::new(0);

/// Independent watchdog of the image.
pub struct IndependentWatchdog;

impl IndependentWatchdog {
    /// Starts the watchdog; only a reset stops it. IWDG_KR (42.4.1), PR (42.4.2), RLR (42.4.3), SR
    /// (42.4.4).
    pub fn start() -> Self {
        // DBGMCU_APB1FZR1 (47.6.5): it pauses while a debugger has halted the processor. TIM1 then
        // drops the enable (`protection.rs`).
        DBGMCU.apb1lfzr().modify(|w| w.set_iwdg(true));
        IWDG.kr().write(|w| w.set_key(Key::START));
        IWDG.kr().write(|w| w.set_key(Key::ENABLE));
        IWDG.pr().write(|w| w.set_pr(Pr::DIVIDE_BY4));
        IWDG.rlr().write(|w| w.set_rl(PERIOD_TICKS - 1));
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

/// Extends the period to eight seconds while the background task checks an update. Blocks continue.
/// Only used in silence, with the amplifier off.
#[cfg(feature = "slot")]
pub fn relax() {
    set_period(Pr::DIVIDE_BY64, 4096);
}

/// Restores the normal period.
#[cfg(feature = "slot")]
pub fn tighten() {
    set_period(Pr::DIVIDE_BY4, PERIOD_TICKS);
}

/// Sets prescaler and period, and feeds the watchdog: IWDG_KR, PR, RLR, SR (42.4).
#[cfg(feature = "slot")]
fn set_period(prescaler: Pr, ticks: u16) {
    IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    IWDG.pr().write(|w| w.set_pr(prescaler));
    IWDG.rlr().write(|w| w.set_rl(ticks - 1));
    while IWDG.sr().read().0 != 0 {}
    IWDG.kr().write(|w| w.set_key(Key::RESET));
}

/// Feeds the watchdog if a block was served since the last call.
pub fn keep_alive() {
    let blocks = count::blocks();
    if LAST_BLOCK.swap(blocks, Ordering::Relaxed) != blocks {
        IWDG.kr().write(|w| w.set_key(Key::RESET));
    }
}
