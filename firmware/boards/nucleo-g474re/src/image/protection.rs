//! Hardware protection: drops the amplifier's enable without any software.
//!
//! The sources are two comparators on the current, the emergency stop, hardware faults of the
//! microcontroller (`supply.rs`), and missing blocks. RM0440 24 (COMP), 28 (TIM1).
//!
//! ```text
//! I (PA1) > upper ---- COMP1 --+-- break  --+
//! I (PA7) < lower ---- COMP2 --+            |
//! microcontroller faults ------+            +-- TIM1 clears MOE --+-- channel 3, PA10, low -- amplifier off
//! stop contact (PC3) low ---------- break 2 -+                    |
//! no block for 200 us --- counter of TIM1 ends at zero ----------+
//! ```
//!
//! * TIM1 is used only for this. A break acts without the clock of TIM1 (28.3.17).
//! * The counter of TIM1 runs once (28.3.22, one-pulse mode); every block resets it to its start
//!   value. Channel 3 is high while the counter is not zero (28.3.12, PWM mode 2). If the processor
//!   stops, in a lockup or under a debugger, the enable therefore drops after 200 us.
//! * The counter keeps running while a debugger has halted the processor. Stopping the counter
//!   (DBG_TIM1_STOP) would drop the output at once, but MOE would stay set, and the amplifier would
//!   be enabled again when the processor continues (28.3.31). Instead, the first block after a halt
//!   detects that the counter has ended and clears MOE: the enable stays low.
//! * The DAC has no break input. The block interrupt reads the flag of the break and plays mid-code
//!   from then on.
//! * After a break the enable stays low until it was ordered low and then high again: [`Enable`].
//! * The thresholds follow the stored current limit (`trips.rs`). They come from the DAC that does
//!   not play.
//! * The comparators, the polarities and the idle level are locked until the next reset.

use core::convert::Infallible;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::asm::delay;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use firmware::board::start::TripFailure;
use nucleo_g474re::blocks::{CYCLES_PER_BLOCK, MISSED};
use nucleo_g474re::trips::{ALWAYS_TRIPPING, Levels, Thresholds};
use stm32_metapac::comp::vals::{Hysteresis, Inm, Polarity};
use stm32_metapac::dac::Dac;
use stm32_metapac::dac::vals::Mode;
use stm32_metapac::gpio::vals::Pupdr;
use stm32_metapac::timer::regs::SrAdv;
use stm32_metapac::timer::vals::{Bkinp, Bkp, CcmrOutputCcs, Lock, Ocm, Ossi, Ossr};
use stm32_metapac::{COMP1, COMP2, DAC1, DAC3, DBGMCU, GPIOA, GPIOC, TIM1};

use super::clocks::CYCLES_PER_US;
use super::dac::{HFSEL, Lanes};
use super::pins::Pin;

/// Pin of the amplifier's enable, TIM1_CH3 (DS12288, alternate functions).
const ENABLE: Pin = Pin::new(GPIOA, 10);
/// Pin of the emergency stop, TIM1_BKIN2 (DS12288, alternate functions).
const STOP: Pin = Pin::new(GPIOC, 3);
/// Alternate function of TIM1 at both pins.
const TIM1_FUNCTION: u8 = 6;
/// Pin of the amplifier's fault output, which is low during a fault.
///
/// It is pulled up, so that an amplifier without such an output reports no fault. Each block reads
/// it. It is not connected to a break, because such an output is often low until the amplifier has
/// its supply. A break at that time would fail the test of the over-current trips at start.
const AMPLIFIER_FAULT: Pin = Pin::new(GPIOA, 6);
/// Index of channel 3 of TIM1, counted from zero.
const CHANNEL_3: usize = 2;
/// Index of the break of TIM1, counted from zero.
const BREAK: usize = 0;
/// Index of break 2 of TIM1, counted from zero.
const BREAK_2: usize = 1;
/// Time without a block after which the enable drops, cycles.
const ALIVE_CYCLES: u32 = MISSED * CYCLES_PER_BLOCK;
/// Start value of the counter at each block, and compare value of the channel: the output is high
/// from this value to the end.
const COUNTER_START: u16 = 1;

/// `true` if the enable was dropped and has not been ordered low since.
static CUT: AtomicBool = AtomicBool::new(false);

/// Arms the protection with these over-current thresholds and the enable low, then tests the
/// over-current trips.
///
/// The sample clock need not run. If the test fails, or if the enable must not rise on this
/// silicon, it stays low until the next reset.
pub fn start(lanes: u8, thresholds: Thresholds, levels: Levels, may_rise: bool) -> (Enable, Stop, Option<TripFailure>) {
    let dac = if Lanes::are_more_than_two(lanes) { DAC1 } else { DAC3 };
    route(dac, thresholds);
    comparators(lanes);
    breaks();
    let failure = levels.failure().or_else(|| test(dac, thresholds, &levels));
    let may_rise = may_rise && failure.is_none();
    if !may_rise {
        set(dac, ALWAYS_TRIPPING);
    }
    ENABLE.alternate(TIM1_FUNCTION, Pupdr::PULL_DOWN);
    (Enable { high: false, may_rise }, Stop, failure)
}

/// Tests the over-current trips while the enable is low.
///
/// Moves each threshold past the current at rest, which must raise the break, and back, after which
/// no break may be raised.
fn test(dac: Dac, thresholds: Thresholds, levels: &Levels) -> Option<TripFailure> {
    let failed = levels.steps(thresholds).into_iter().find(|&(thresholds, must_trip, _)| {
        set(dac, thresholds);
        // The flag stays clear only if the input of the break is clear: TIM1_SR.BIF (28.6.5).
        clear(|w| w.set_bif(BREAK, false));
        delay(CYCLES_PER_US);
        TIM1.sr().read().bif(BREAK) != must_trip
    });
    failed.map(|(_, _, failure)| failure)
}

/// Sets the thresholds and waits until the DAC has settled: DAC_DHR12Rx (22.7.3, 22.7.6).
fn set(dac: Dac, (upper, lower): Thresholds) {
    dac.dhr12r(0).write(|w| w.set_dhr(upper));
    dac.dhr12r(1).write(|w| w.set_dhr(lower));
    delay(10 * CYCLES_PER_US);
}

/// Connects the DAC that does not play to the comparators only, as the source of the thresholds:
/// DAC_MCR (22.7.17), DAC_CR (22.7.1).
///
/// The thresholds are set before the outputs are enabled.
fn route(dac: Dac, thresholds: Thresholds) {
    dac.mcr().modify(|w| {
        w.set_hfsel(HFSEL);
        w.set_mode(0, Mode::NORMAL_INT_BUFDIS);
        w.set_mode(1, Mode::NORMAL_INT_BUFDIS);
    });
    // After the mode: the DAC of a related part may lose data that is written before it (ES0418
    // 2.7.1).
    set(dac, thresholds);
    dac.cr().modify(|w| {
        w.set_en(0, true);
        w.set_en(1, true);
    });
    delay(10 * CYCLES_PER_US);
}

/// Configures and locks the comparators of the current and the thresholds: COMP_CxCSR (24.6.1).
fn comparators(lanes: u8) {
    // INMSEL (24.3.2): DAC3 channel 1 or 2, or DAC1 channel 1 or 2.
    let threshold = if Lanes::are_more_than_two(lanes) { Inm::DACB } else { Inm::DACA };
    // INPSEL = 0 (24.3.2): PA1 for COMP1, PA7 for COMP2. The output of COMP2 is inverted: it is
    // high below the lower threshold.
    for (comparator, polarity) in [(COMP1, Polarity::NOT_INVERTED), (COMP2, Polarity::INVERTED)] {
        comparator.csr().modify(|w| {
            w.set_inmsel(threshold);
            w.set_inpsel(false);
            w.set_polarity(polarity);
            w.set_hyst(Hysteresis::HYST30M);
            w.set_en(true);
        });
        // t_START (DS12288, comparator characteristics) is at most 5 us.
        delay(10 * CYCLES_PER_US);
        comparator.csr().modify(|w| w.set_lock(true));
    }
}

/// Pins of the current at the two comparators: PA1, which the ADC converts, and PA7.
pub const CURRENT: [Pin; 2] = [Pin::new(GPIOA, 1), Pin::new(GPIOA, 7)];

/// Configures TIM1: channel 3 low, and the breaks with their sources.
fn breaks() {
    // Pulled down, so that a broken wire counts as a stop.
    STOP.alternate(TIM1_FUNCTION, Pupdr::PULL_DOWN);
    AMPLIFIER_FAULT.input(Pupdr::PULL_UP);
    // DBGMCU_APB2FZR (47.6.7), which a reset does not change: the counter keeps running while a
    // debugger has halted the processor.
    DBGMCU.apb2fzr().modify(|w| w.set_tim1(false));
    // CR1.OPM (28.6.1), ARR (28.6.14), CCR3 (28.6.18): one run of the counter, which lasts
    // `ALIVE_CYCLES` cycles.
    TIM1.cr1().modify(|w| w.set_opm(true));
    TIM1.arr().write(|w| w.set_arr(ALIVE_CYCLES as u16 - 1));
    TIM1.ccr(CHANNEL_3).write(|w| w.set_ccr(COUNTER_START));
    // The output is forced inactive. CR2.OIS3 (28.6.2), its idle level, is low after reset.
    force(Ocm::FORCE_INACTIVE);
    // CCER.CC3E (28.6.11).
    TIM1.ccer().modify(|w| w.set_cce(CHANNEL_3, true));
    // AF1 (28.6.26): break from the comparators, not from a pin. AF2 (28.6.27): break 2 from the
    // pin, inverted, so that low is a break.
    TIM1.af1().modify(|w| {
        w.set_bkine(false);
        w.set_bkcmpe(0, true);
        w.set_bkcmpe(1, true);
    });
    TIM1.af2().modify(|w| {
        w.set_bk2ine(true);
        w.set_bk2inp(Bkinp::INVERTED);
    });
    // BDTR (28.6.20): both breaks are active high. BKE also enables the microcontroller faults as
    // sources (28.3.17). There is no filter, so the breaks need no clock. When off, the output is
    // held low; it never switches on automatically. The lock must be written last.
    TIM1.bdtr().write(|w| {
        for number in [BREAK, BREAK_2] {
            w.set_bkp(number, Bkp::ACTIVE_HIGH);
            w.set_bke(number, true);
        }
        w.set_ossi(Ossi::IDLE_LEVEL);
        w.set_ossr(Ossr::IDLE_LEVEL);
        w.set_lock(Lock::LEVEL1);
    });
}

/// Sets the output mode of channel 3: CCMR2.OC3M (28.6.10).
fn force(level: Ocm) {
    TIM1.ccmr_output(1).modify(|w| {
        w.set_ccs(0, CcmrOutputCcs::OUTPUT);
        w.set_ocm(0, level);
    });
}

/// Clears flags of TIM1_SR (28.6.5): writing zero clears a flag, writing one leaves it unchanged.
fn clear(flags: impl FnOnce(&mut SrAdv)) {
    let mut cleared = SrAdv(u32::MAX);
    flags(&mut cleared);
    TIM1.sr().write_value(cleared);
}

/// State of the breaks, for the block interrupt.
pub struct BreakState {
    /// `true` if the comparators have dropped the enable since the last block.
    pub over_current: bool,
    /// `true` while the amplifier reports a fault.
    pub amplifier_fault: bool,
    /// `true` if the counter has ended: no block was served for 200 us.
    pub stalled: bool,
    /// `true` if the enable was dropped and has not been ordered low since: the block interrupt
    /// must play mid-code.
    pub cut: bool,
}

/// Reads and clears the flags of the breaks and of the counter's end: TIM1_SR.BIF, B2IF, UIF
/// (28.6.5).
///
/// A break whose input is still active is set again at once. Drops the enable if any flag was set.
/// Unless the enable was dropped, resets the counter to its start value: TIM1_CNT (28.6.12).
pub fn check_breaks() -> BreakState {
    let flags = TIM1.sr().read();
    let (over_current, stopped, stalled) = (flags.bif(BREAK), flags.bif(BREAK_2), flags.uif());
    if over_current || stopped || stalled {
        // A break has already cleared MOE; the end of the counter has not.
        drop_enable();
        clear(|w| {
            w.set_bif(BREAK, !over_current);
            w.set_bif(BREAK_2, !stopped);
            w.set_uif(!stalled);
        });
    }
    let cut = CUT.load(Ordering::Relaxed);
    if !cut {
        TIM1.cnt().write(|w| w.set_cnt(COUNTER_START));
    }
    BreakState { over_current, amplifier_fault: !AMPLIFIER_FAULT.is_high(), stalled, cut }
}

/// Drops the enable; may be called from anywhere. The enable stays low until it was ordered low and
/// then high again. TIM1_BDTR.MOE (28.6.20).
pub fn drop_enable() {
    CUT.store(true, Ordering::Relaxed);
    TIM1.bdtr().modify(|w| w.set_moe(false));
}

/// Output of the amplifier's enable. After a break it stays low until it was set low and then high
/// again.
pub struct Enable {
    high: bool,
    /// `true` if the over-current trips have passed their test, on silicon that is not refused.
    may_rise: bool,
}

impl ErrorType for Enable {
    type Error = Infallible;
}

impl OutputPin for Enable {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.high = false;
        TIM1.bdtr().modify(|w| w.set_moe(false));
        force(Ocm::FORCE_INACTIVE);
        CUT.store(false, Ordering::Relaxed);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        // Only a change from low to high arms the output. Every poll sets it high again, which must
        // not undo a break.
        if !self.high && self.may_rise {
            self.high = true;
            // CR1.CEN (28.6.1): the counter begins at zero, at which the channel is low.
            TIM1.cr1().modify(|w| w.set_cen(false));
            TIM1.cnt().write(|w| w.set_cnt(0));
            force(Ocm::PWM_MODE2);
            // A set SBIF, from a microcontroller fault that has ended, would keep the outputs
            // low (28.6.5).
            clear(|w| {
                w.set_uif(false);
                w.set_sbif(false);
            });
            // This has no effect while the input of a break is active.
            TIM1.bdtr().modify(|w| w.set_moe(true));
            TIM1.cr1().modify(|w| w.set_cen(true));
        }
        Ok(())
    }
}

/// Contact of the emergency stop, which connects the pin to 3.3 V while it is released.
pub struct Stop;

impl ErrorType for Stop {
    type Error = Infallible;
}

impl InputPin for Stop {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(STOP.is_high())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!STOP.is_high())
    }
}
