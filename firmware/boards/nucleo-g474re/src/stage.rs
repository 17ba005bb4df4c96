//! Hardware part of the first stage.
#![expect(unsafe_code, reason = "starting another image and exception handlers are unsafe")]

#[path = "first_access.rs"]
mod first_access;
#[expect(dead_code, reason = "only the image uses the settings")]
#[path = "image/flash.rs"]
mod flash;
#[path = "stage/watchdog.rs"]
mod watchdog;

use core::panic::PanicInfo;

use cortex_m::{Peripherals, asm};
use cortex_m_rt::{entry, exception};
use nucleo_g474re::slots::{BOARD, MANIFEST, ORIGIN, SLOT, STATE, STORE};
use stm32_metapac::FLASH;
use update::check::Target;
use update::first_stage::{Decision, decide};
use update::identity::board;
use update::key;

use self::flash::{Damage, Pages};

#[entry]
fn main() -> ! {
    watchdog::start();
    let target = Target { board: board(BOARD), origin: ORIGIN, room: SLOT.size - MANIFEST, keys: &key::PUBLIC };
    let [mut slot, mut store, mut state] = [SLOT, STORE, STATE].map(|area| Pages::new(area, Damage::Zeros));
    match decide(&mut slot, &mut store, &mut state, &target) {
        Decision::Start => start_image(),
        // No valid image: the watchdog resets the processor, and the first stage tries again.
        Decision::Nothing => wait_for_watchdog(),
    }
}

/// Starts the image in the slot, with the watchdog running.
fn start_image() -> ! {
    // FLASH_ACR.ICRST, which requires the cache to be off (RM0440 3.7.1): the slot may have
    // changed.
    FLASH.acr().modify(|w| w.set_icen(false));
    FLASH.acr().modify(|w| w.set_icrst(true));
    FLASH.acr().modify(|w| w.set_icrst(false));
    FLASH.acr().modify(|w| w.set_icen(true));
    watchdog::keep_alive();
    // SAFETY: no code of this program runs afterwards, no interrupt is enabled, and the image was
    // checked.
    unsafe {
        let core = Peripherals::steal();
        core.SCB.vtor.write(ORIGIN);
        asm::bootload(ORIGIN as *const u32)
    }
}

/// Waits until the watchdog resets the processor.
fn wait_for_watchdog() -> ! {
    loop {
        asm::nop();
    }
}

// SAFETY: unsafe because this interrupt cannot be masked; the handler uses only registers and
// atomics.
#[exception]
unsafe fn NonMaskableInt() {
    let status = FLASH.eccr().read();
    if status.eccd() || status.eccd2() {
        flash::mark_damaged();
        // Writing one clears ECCD (3.7.6).
        FLASH.eccr().write_value(status);
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    wait_for_watchdog()
}
