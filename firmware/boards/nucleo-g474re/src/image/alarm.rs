//! Handler of the non-maskable interrupt. [`Alarm`] classifies its reason.
//!
//! A damaged word of the settings makes its read fail. Every other reason ends the run. The
//! hardware has already dropped the enable: the failures of crystal, flash and RAM are inputs of
//! the break of TIM1 (`supply.rs`).
#![expect(unsafe_code, reason = "the handler of an exception is unsafe")]

use boards_common::note::Cause;
use cortex_m_rt::exception;
use nucleo_g474re::alarm::{Alarm, Word};
use stm32_metapac::{FLASH, RCC, SYSCFG};

use super::{flash, panic, protection};

// SAFETY: unsafe because this interrupt cannot be masked. The handler uses only registers and
// atomics, and ends the run if an invariant may be broken.
#[exception]
unsafe fn NonMaskableInt() {
    // FLASH_ECCR (3.7.6): ECCD for the lower and ECCD2 for the upper half of a line, the bank, and
    // the offset within the bank.
    let status = FLASH.eccr().read();
    let word = (status.eccd() || status.eccd2()).then(|| Word {
        in_system_memory: status.sysf_ecc(),
        in_second_bank: status.bk_ecc(),
        offset: status.addr_ecc(),
    });
    // RCC_CIFR.CSSF (7.4.6), SYSCFG_CFGR2.SPF (10.2.8), FLASH_OPTR.DBANK.
    let alarm = Alarm::from_flags(RCC.cifr().read().cssf(), SYSCFG.cfgr2().read().spf(), word, FLASH.optr().read().dbank());
    match alarm {
        Alarm::Settings => {
            protection::drop_enable();
            flash::mark_damaged();
            // Writing one clears ECCD (3.7.6).
            FLASH.eccr().write_value(status);
        }
        Alarm::Code(address) => panic::end(Cause::DamagedCode, "", address),
        Alarm::ClockFailed => panic::end(Cause::ClockFailed, "", 0),
        Alarm::RamParity => panic::end(Cause::RamParity, "", 0),
        Alarm::Unknown => panic::end(Cause::Unexpected, "non-maskable interrupt", 0),
    }
}
