//! Sample clock: TIM3 triggers the DACs at 1 MHz and starts TIM4, which triggers the ADCs at 2 MHz.
//!
//! ```text
//! TIM3 update    |---------------------------|   1 us, 170 cycles: every DAC steps
//! TIM4 compare        ^             ^            500 ns, 85 cycles: both ADCs convert, twice a sample
//! ```
//!
//! Both timers count the same clock, so they never drift apart. The two conversions of a sample are
//! 500 ns apart, so their sum suppresses signals at 1 MHz and attenuates the DAC's images near 1
//! MHz. [`TRIGGER_AFTER`] sets their position. A shift of both is a constant delay, which the
//! calibration of the lock-in removes.
//!
//! Both timers keep running while a debugger has halted the processor (DBGMCU_APB1FZR1, 47.6.5, as
//! after power-up). RM0440 29: general-purpose timers.

use core::ops::RangeInclusive;

use nucleo_g474re::blocks::CYCLES_PER_SAMPLE;
use nucleo_g474re::sampling::{CYCLES_PER_CONVERSION, TRIGGER_AFTER};
use stm32_metapac::timer::vals::{Mms, Ocm, Sms, Ts, Urs};
use stm32_metapac::{TIM3, TIM4};

/// Configures both timers. The converters must be ready for triggers when [`start`] is called.
pub fn prepare() {
    // TIM4: TIMx_ARR (29.5.14), CCR1 (29.5.15), CCMR1.OC1M = PWM mode 2, low below the compare
    // value, otherwise high (29.5.8).
    TIM4.arr().write(|w| w.set_arr(CYCLES_PER_CONVERSION as u16 - 1));
    TIM4.ccr(0).write(|w| w.set_ccr(TRIGGER_AFTER as u16));
    TIM4.ccmr_output(0).modify(|w| w.set_ocm(0, Ocm::PWM_MODE2));
    // CR2.MMS = OC1REF as TRGO (29.5.2): a rising edge for each conversion.
    TIM4.cr2().modify(|w| w.set_mms(Mms::COMPARE_OC1));
    // SMCR (29.5.3): started by ITR2, which is TIM3 (RM0440 11.3.1 and the table of internal
    // triggers in 29.4).
    TIM4.smcr().modify(|w| {
        w.set_ts(Ts::ITR2);
        w.set_sms(Sms::TRIGGER_MODE);
    });
    // TIM3: only an overflow counts as an update, so that this configuration causes no trigger
    // (CR1.URS, 29.5.1).
    TIM3.cr1().modify(|w| w.set_urs(Urs::COUNTER_ONLY));
    TIM3.arr().write(|w| w.set_arr(CYCLES_PER_SAMPLE as u16 - 1));
    // CR2.MMS = update as TRGO.
    TIM3.cr2().modify(|w| w.set_mms(Mms::UPDATE));
}

/// Cycles of a sample in which neither ring of samples moves: both have moved before, and the ADC's
/// ring moves 85 cycles later than usual, from cycle 92 on, if it has missed one of the two
/// triggers of a sample. The position of the ADC's ring is read first, within 20 cycles.
const QUIET: RangeInclusive<u16> = 30..=68;

/// Cycles between two reads of the counter in [`await_quiet`], at least.
const MIN_READ_CYCLES: u32 = 6;

/// Waits for the quiet part of the sample: at most one sample if the clock runs, and about two if
/// it has stopped.
#[inline]
pub fn await_quiet() {
    for _ in 0..CYCLES_PER_SAMPLE / MIN_READ_CYCLES {
        if QUIET.contains(&(TIM3.cnt().read().0 as u16)) {
            return;
        }
    }
}

/// Waits for the quiet part of the next sample, if the clock runs.
pub fn await_next_quiet() {
    for _ in 0..CYCLES_PER_SAMPLE / MIN_READ_CYCLES {
        if !QUIET.contains(&(TIM3.cnt().read().0 as u16)) {
            break;
        }
    }
    await_quiet();
}

/// Returns `true` if the sample clock counts.
pub fn is_running() -> bool {
    TIM3.cnt().read() != TIM3.cnt().read()
}

/// Starts the sample clock: CR1.CEN (29.5.1).
pub fn start() {
    TIM3.cr1().modify(|w| w.set_cen(true));
}
