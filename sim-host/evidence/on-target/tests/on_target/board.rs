//! Tests of the hardware of the board, in its state after a reset. These tests have not been run
//! yet.
//!
//! Tests that need the board's converters running (mid-code on its outputs and inputs) are not
//! here, because the modules that start the converters belong to the board's image. The first-power
//! checklist of docs/board.md covers them.
#![expect(unsafe_code, reason = "memory outside the linker script")]

use core::ptr;

use cortex_m::asm::delay;
use stm32_metapac::gpio::Gpio;
use stm32_metapac::gpio::vals::{Idr, Moder, Pupdr};
use stm32_metapac::{FLASH, GPIOA, GPIOC, RCC};

/// Pin of the amplifier's enable; high is on (docs/board.md, Pins).
const ENABLE: (Gpio, usize) = (GPIOA, 10);
/// Pin of the emergency stop's contact; high is released (docs/board.md, Pins).
const STOP: (Gpio, usize) = (GPIOC, 3);
/// Address of the core-coupled RAM on its own bus (RM0440 2.2.1).
const CCMRAM: usize = 0x1000_0000;
const CCMRAM_BYTES: usize = 32 << 10;

/// Returns the level at a pin: RCC_AHB2ENR (RM0440 7.4.15), GPIOx_MODER (9.4.1), PUPDR (9.4.4),
/// IDR (9.4.5).
fn level((port, number): (Gpio, usize), pull: Pupdr) -> Idr {
    RCC.ahb2enr().modify(|w| {
        w.set_gpioaen(true);
        w.set_gpiocen(true);
    });
    // The clock takes two cycles (7.2.17); the wire must charge through the pull-up of 40 kilohms.
    delay(16);
    port.pupdr().modify(|w| w.set_pupdr(number, pull));
    port.moder().modify(|w| w.set_moder(number, Moder::INPUT));
    delay(16_000);
    port.idr().read().idr(number)
}

/// Checks the resistor at the amplifier: against the part's own pull-up of 40 kilohms, the pin
/// still reads low.
pub fn the_amplifier_is_off() {
    assert!(level(ENABLE, Pupdr::PULL_UP) == Idr::LOW, "PA10 is not held low: is there 10 kilohms to ground at the amplifier?");
}

pub fn the_emergency_stop_is_released() {
    assert!(level(STOP, Pupdr::PULL_DOWN) == Idr::HIGH, "PC3 is low: pressed, or not wired to 3.3 V");
}

/// Checks FLASH_OPTR.DBANK (3.7.7): with a single bank nothing is stored.
pub fn the_flash_has_two_banks() {
    assert!(FLASH.optr().read().dbank(), "option byte DBANK is off");
}

pub fn the_core_coupled_ram_keeps_what_is_written() {
    let words = || (CCMRAM..CCMRAM + CCMRAM_BYTES).step_by(4);
    for address in words() {
        // SAFETY: this image uses none of that RAM.
        unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut::<u32>(address), !address as u32) };
    }
    for address in words() {
        // SAFETY: as above.
        let word = unsafe { ptr::read_volatile(ptr::with_exposed_provenance::<u32>(address)) };
        assert_eq!(word, !address as u32, "{address:#x}");
    }
}
