//! Supply of the microcontroller: its detector, and the microcontroller faults that drop the
//! amplifier's enable in hardware.
//!
//! ```text
//! lockup of the processor --+
//! supply below 2.9 V -------+-- SYSCFG_CFGR2 -- break of TIM1 -- PA10 low
//! parity of the RAM --------+
//! double error of the flash +
//! failure of the crystal ---------------------- (always connected)
//! ```
//!
//! The parity check of the RAM is an option byte (SRAM_PE); it is off as delivered.
#![expect(unsafe_code, reason = "enabling an interrupt is unsafe")]

use boards_common::note::Cause;
use cortex_m::asm::delay;
use cortex_m::peripheral::NVIC;
use stm32_metapac::syscfg::regs::Cfgr2;
use stm32_metapac::{EXTI, FLASH, Interrupt, PWR, SYSCFG, interrupt};

use super::clocks::CYCLES_PER_US;
use super::panic;

/// Level of the detector, PWR_CR2.PLS: 2.9 V, the highest one (DS12288, V_PVD6).
const DETECTOR_LEVEL: u8 = 6;
/// EXTI line of the detector (RM0440 15.3.2, table of lines).
const DETECTOR_LINE: usize = 16;
/// Value of FLASH_OPTR.BOR_LEV for a reset below 2.8 V.
const HIGHEST_RESET_LEVEL: u8 = 4;

/// Starts the detector, waits until the supply is above its level, and connects the faults to the
/// break.
///
/// These connections stay until a reset.
pub fn watch() {
    // PWR_CR2.PLS, PVDE (6.4.2).
    PWR.cr2().modify(|w| {
        w.set_pls(DETECTOR_LEVEL);
        w.set_pvde(true);
    });
    // The detector is ready within microseconds. PWR_SR2.PVDO (6.4.7): the supply is below the
    // level.
    delay(100 * CYCLES_PER_US);
    if PWR.sr2().read().pvdo() {
        defmt::error!("the supply is below 2.9 V: waiting until it rises");
        while PWR.sr2().read().pvdo() {}
    }
    let reset_level = FLASH.optr().read().bor_lev();
    if reset_level < HIGHEST_RESET_LEVEL {
        defmt::warn!("option byte BOR_LEV is {=u8}: set it to 4, for a reset below 2.8 V", reset_level);
    }
    // SYSCFG_CFGR2 (10.2.8): CLL, SPL, PVDL, ECCL, which only a reset clears. PVDL also locks
    // PWR_CR2.
    let mut faults = Cfgr2(0);
    faults.set_cll(true);
    faults.set_spl(true);
    faults.set_pvdl(true);
    faults.set_eccl(true);
    SYSCFG.cfgr2().write_value(faults);
    // EXTI_RTSR1 (15.5.3), PR1 (15.5.6), IMR1 (15.5.1): PVDO rises as the supply falls.
    EXTI.rtsr(0).modify(|w| w.set_line(DETECTOR_LINE, true));
    EXTI.pr(0).write(|w| w.set_line(DETECTOR_LINE, true));
    EXTI.imr(0).modify(|w| w.set_line(DETECTOR_LINE, true));
    // SAFETY: the handler uses only registers and the note.
    unsafe { NVIC::unmask(Interrupt::PVD_PVM) };
}

/// Ends the run after a low supply. The break has already dropped the enable.
#[interrupt]
fn PVD_PVM() {
    panic::end(Cause::SupplyLow, "", 0);
}
