//! What drops the amplifier's enable without the processor: two comparators on the current, the emergency stop, the faults of the part
//! (`supply.rs`), and blocks that do not come. RM0440 24 (COMP), 28 (TIM1).
//!
//! ```text
//! I (PA1) > upper ---- COMP1 --+-- break  --+
//! I (PA7) < lower ---- COMP2 --+            |
//! faults of the part ----------+            +-- TIM1 drops MOE --+-- channel 3, PA10, low -- amplifier off
//! stop contact (PC3) low ---------- break 2 -+                    |
//! no block for 200 us --- counter of TIM1 ends at zero ----------+
//! ```
//!
//! * TIM1 is used for nothing else. A break acts without its clock (28.3.17).
//! * The counter of TIM1 runs once (28.3.22, one-pulse mode), and every block puts it back to its beginning. Channel 3 is high while the counter is
//!   not zero (28.3.12, PWM mode 2): a processor that stands, in a lockup or by a debugger, drops the enable after 200 us.
//! * The counter runs on while a debugger has halted the processor. Stopping it (DBG_TIM1_STOP) would drop the output at once, but MOE would stay
//!   set, and the amplifier would come back as the processor goes on (28.3.31). The block that follows a halt finds that the counter has ended, and drops
//!   MOE: the enable stays down.
//! * The DAC has no break input: the block interrupt sees the break's flag, and plays mid-code from then on.
//! * The enable stays down until it was ordered low and then high again: [`Enable`].
//! * The thresholds follow the stored current limit (`trips.rs`), and come from the DAC that does not play. The comparators, the polarities and the idle level are locked until the next reset.

use core::convert::Infallible;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::asm::delay;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use firmware::board::start::TripFailure;
use nucleo_g474re::blocks::{CYCLES_PER_BLOCK, MISSED};
use nucleo_g474re::trips::{ALWAYS, Levels, Thresholds};
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

/// TIM1_CH3, the amplifier's enable, and TIM1_BKIN2, the emergency stop (DS12288, alternate functions).
const ENABLE: Pin = Pin::new(GPIOA, 10);
const STOP: Pin = Pin::new(GPIOC, 3);
const TIM1_FUNCTION: u8 = 6;
/// The amplifier's fault output, low while it has one; pulled up, so that an amplifier without one reports none. Each block reads it. It is no break: such an
/// output is often low until the amplifier has its supply, and a break that stands would fail the test of the trips at start.
const AMPLIFIER_FAULT: Pin = Pin::new(GPIOA, 6);
/// Of TIM1's channels and breaks, counted from zero.
const CHANNEL_3: usize = 2;
const BREAK: usize = 0;
const BREAK_2: usize = 1;
/// Cycles without a block after which the enable drops.
const ALIVE: u32 = MISSED * CYCLES_PER_BLOCK;
/// Where each block puts the counter, and the channel's compare value: high from here to the end.
const BEGINNING: u16 = 1;

/// A break has dropped the enable, and it has not been ordered low since.
static CUT: AtomicBool = AtomicBool::new(false);

/// Arms the protection with these over-current thresholds and the enable down, and tests the over-current trips; the sample clock need not run.
pub fn start(lanes: u8, thresholds: Thresholds, levels: Levels) -> (Enable, Stop, Option<TripFailure>) {
    let dac = if Lanes::are_four(lanes) { DAC1 } else { DAC3 };
    route(dac, thresholds);
    comparators(lanes);
    breaks();
    let failure = levels.failure().or_else(|| test(dac, thresholds, &levels));
    if failure.is_some() {
        set(dac, ALWAYS);
    }
    ENABLE.alternate(TIM1_FUNCTION, Pupdr::PULL_DOWN);
    (Enable { high: false, may_rise: failure.is_none() }, Stop, failure)
}

/// Moves each threshold past the current at rest, which must raise the break, and back; the enable is down.
fn test(dac: Dac, thresholds: Thresholds, levels: &Levels) -> Option<TripFailure> {
    let failed = levels.steps(thresholds).into_iter().find(|&(thresholds, must_trip, _)| {
        set(dac, thresholds);
        // The flag stays clear only where the input of the break is: TIM1_SR.BIF (28.6.5).
        clear(|w| w.set_bif(BREAK, false));
        delay(CYCLES_PER_US);
        TIM1.sr().read().bif(BREAK) != must_trip
    });
    failed.map(|(_, _, failure)| failure)
}

/// Sets the thresholds and waits until they are there: DAC_DHR12Rx (22.7.3, 22.7.6).
fn set(dac: Dac, (upper, lower): Thresholds) {
    dac.dhr12r(0).write(|w| w.set_dhr(upper));
    dac.dhr12r(1).write(|w| w.set_dhr(lower));
    delay(10 * CYCLES_PER_US);
}

/// The thresholds, from the DAC that does not play, to the comparators only: DAC_MCR (22.7.17), DAC_CR (22.7.1). They are there before the outputs are.
fn route(dac: Dac, thresholds: Thresholds) {
    dac.mcr().modify(|w| w.set_hfsel(HFSEL));
    set(dac, thresholds);
    dac.mcr().modify(|w| {
        w.set_mode(0, Mode::NORMAL_INT_BUFDIS);
        w.set_mode(1, Mode::NORMAL_INT_BUFDIS);
    });
    dac.cr().modify(|w| {
        w.set_en(0, true);
        w.set_en(1, true);
    });
    delay(10 * CYCLES_PER_US);
}

/// COMP_CxCSR (24.6.1): the current against the thresholds.
fn comparators(lanes: u8) {
    // INMSEL (24.3.2): DAC3 channel 1 or 2, or DAC1 channel 1 or 2.
    let threshold = if Lanes::are_four(lanes) { Inm::DACB } else { Inm::DACA };
    // INPSEL = 0 (24.3.2): PA1 of COMP1, PA7 of COMP2. The lower one is true below its threshold.
    for (comparator, polarity) in [(COMP1, Polarity::NOT_INVERTED), (COMP2, Polarity::INVERTED)] {
        comparator.csr().modify(|w| {
            w.set_inmsel(threshold);
            w.set_inpsel(false);
            w.set_polarity(polarity);
            w.set_hyst(Hysteresis::HYST30M);
            w.set_en(true);
        });
        // t_START (DS12288, comparator characteristics) is 5 us at most.
        delay(10 * CYCLES_PER_US);
        comparator.csr().modify(|w| w.set_lock(true));
    }
}

/// The current, at both comparators: PA1, which the ADC converts, and PA7.
pub const CURRENT: [Pin; 2] = [Pin::new(GPIOA, 1), Pin::new(GPIOA, 7)];

/// TIM1: channel 3 down, and what breaks it.
fn breaks() {
    // A wire that is broken is a stop.
    STOP.alternate(TIM1_FUNCTION, Pupdr::PULL_DOWN);
    AMPLIFIER_FAULT.input(Pupdr::PULL_UP);
    // DBGMCU_APB2FZR (47.6.7), which a reset leaves as it is: the counter runs on while a debugger has halted the processor.
    DBGMCU.apb2fzr().modify(|w| w.set_tim1(false));
    // CR1.OPM (28.6.1), ARR (28.6.14), CCR3 (28.6.18): once, for as long.
    TIM1.cr1().modify(|w| w.set_opm(true));
    TIM1.arr().write(|w| w.set_arr(ALIVE as u16 - 1));
    TIM1.ccr(CHANNEL_3).write(|w| w.set_ccr(BEGINNING));
    // Forced inactive. CR2.OIS3 (28.6.2) is low after reset.
    force(Ocm::FORCE_INACTIVE);
    // CCER.CC3E (28.6.11).
    TIM1.ccer().modify(|w| w.set_cce(CHANNEL_3, true));
    // AF1 (28.6.26): the comparators, and no pin. AF2 (28.6.27): the pin, inverted, so that low is a break.
    TIM1.af1().modify(|w| {
        w.set_bkine(false);
        w.set_bkcmpe(0, true);
        w.set_bkcmpe(1, true);
    });
    TIM1.af2().modify(|w| {
        w.set_bk2ine(true);
        w.set_bk2inp(Bkinp::INVERTED);
    });
    // BDTR (28.6.20): both breaks, high; BKE also lets the faults of the part through (28.3.17). No filter, so that they need no clock; held low when off,
    // and never on by itself. The lock is the last that can be written.
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

/// CCMR2.OC3M (28.6.10).
fn force(level: Ocm) {
    TIM1.ccmr_output(1).modify(|w| {
        w.set_ccs(0, CcmrOutputCcs::OUTPUT);
        w.set_ocm(0, level);
    });
}

/// Clears flags of TIM1_SR (28.6.5): zero clears, one leaves as it is.
fn clear(flags: impl FnOnce(&mut SrAdv)) {
    let mut cleared = SrAdv(u32::MAX);
    flags(&mut cleared);
    TIM1.sr().write_value(cleared);
}

/// The state of the breaks, for the block interrupt.
pub struct Broken {
    /// The comparators have dropped the enable since the last block.
    pub over_current: bool,
    /// The amplifier reports a fault at present.
    pub amplifier_fault: bool,
    /// The counter has ended: the processor stood.
    pub stood: bool,
    /// The enable is down since a break: play mid-code.
    pub cut: bool,
}

/// Looks at the flags of the breaks and of the counter's end, and clears them: TIM1_SR.BIF, B2IF, UIF (28.6.5). A break whose input still stands is set
/// again at once. Then puts the counter back to its beginning: TIM1_CNT (28.6.12).
pub fn look() -> Broken {
    let flags = TIM1.sr().read();
    let (over_current, stopped, stood) = (flags.bif(BREAK), flags.bif(BREAK_2), flags.uif());
    if over_current || stopped || stood {
        // A break has cleared MOE; the counter's end has not.
        drop_enable();
        clear(|w| {
            w.set_bif(BREAK, !over_current);
            w.set_bif(BREAK_2, !stopped);
            w.set_uif(!stood);
        });
    }
    let cut = CUT.load(Ordering::Relaxed);
    if !cut {
        TIM1.cnt().write(|w| w.set_cnt(BEGINNING));
    }
    Broken { over_current, amplifier_fault: !AMPLIFIER_FAULT.is_high(), stood, cut }
}

/// Drops the enable, from anywhere, for good: it must be ordered low before it can rise again. TIM1_BDTR.MOE (28.6.20).
pub fn drop_enable() {
    CUT.store(true, Ordering::Relaxed);
    TIM1.bdtr().modify(|w| w.set_moe(false));
}

/// The amplifier's enable. After a break it stays low until it was set low.
pub struct Enable {
    high: bool,
    /// The over-current trips have passed their test.
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
        // Only the edge arms it: it is set again at every poll, and must not undo a break by that.
        if !self.high && self.may_rise {
            self.high = true;
            // CR1.CEN (28.6.1): the counter begins at zero, where the channel is low.
            TIM1.cr1().modify(|w| w.set_cen(false));
            TIM1.cnt().write(|w| w.set_cnt(0));
            force(Ocm::PWM_MODE2);
            // SBIF, of a fault of the part that is over, would keep the outputs down (28.6.5).
            clear(|w| {
                w.set_uif(false);
                w.set_sbif(false);
            });
            // A break whose input still stands keeps this from being set.
            TIM1.bdtr().modify(|w| w.set_moe(true));
            TIM1.cr1().modify(|w| w.set_cen(true));
        }
        Ok(())
    }
}

/// The emergency stop's contact, to 3.3 V while it is released.
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
