//! What drops the amplifier's enable without the processor: two comparators on the current, and the emergency stop. RM0440 24 (COMP), 28 (TIM1).
//!
//! ```text
//! I (PA1) > upper ---- COMP1 --+-- break  --+
//! I (PA7) < lower ---- COMP2 --+            +-- TIM1 drops MOE -- channel 3, PA10, low -- amplifier off
//! stop contact (PC3) low ---------- break 2 -+
//! ```
//!
//! * TIM1 is used for nothing else: its channel 3 is forced high or low, its counter stands still, and a break acts without a clock (28.3.17).
//! * The DAC has no break input: the block interrupt sees the break's flag, and plays mid-code from then on.
//! * The enable stays down until it was ordered low and then high again: [`Enable`].
//! * The thresholds come from the DAC that does not play. The comparators, the polarities and the idle level are locked until the next reset.
//! * A debugger that halts the processor halts TIM1, and that drops its outputs too.

use core::convert::Infallible;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::asm::delay;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use nucleo_g474re::config::{TRIP_A, trip_codes};
use stm32_metapac::comp::vals::{Hysteresis, Inm, Polarity};
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
/// Of TIM1's channels and breaks, counted from zero.
const CHANNEL_3: usize = 2;
const BREAK: usize = 0;
const BREAK_2: usize = 1;

/// A break has dropped the enable, and nobody has ordered it low since.
static CUT: AtomicBool = AtomicBool::new(false);

/// Arms the protection, with the enable down; the sample clock need not run.
pub fn start(lanes: u8) -> (Enable, Stop) {
    thresholds(lanes);
    comparators(lanes);
    breaks();
    ENABLE.alternate(TIM1_FUNCTION, Pupdr::PULL_DOWN);
    (Enable { high: false }, Stop)
}

/// The thresholds, from the DAC that does not play, to the comparators only: DAC_MCR (22.7.17), DAC_DHR12Rx (22.7.3, 22.7.6), DAC_CR (22.7.1).
fn thresholds(lanes: u8) {
    let dac = if Lanes::are_four(lanes) { DAC1 } else { DAC3 };
    let (upper, lower) = trip_codes(TRIP_A);
    dac.mcr().modify(|w| {
        w.set_mode(0, Mode::NORMAL_INT_BUFDIS);
        w.set_mode(1, Mode::NORMAL_INT_BUFDIS);
        w.set_hfsel(HFSEL);
    });
    dac.dhr12r(0).write(|w| w.set_dhr(upper));
    dac.dhr12r(1).write(|w| w.set_dhr(lower));
    dac.cr().modify(|w| {
        w.set_en(0, true);
        w.set_en(1, true);
    });
    delay(10 * CYCLES_PER_US);
}

/// COMP_CxCSR (24.6.1): the current against the thresholds.
fn comparators(lanes: u8) {
    GPIOA_CURRENT.into_iter().for_each(Pin::analog);
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

/// The current, at both comparators: PA1, which the ADC has too, and PA7.
const GPIOA_CURRENT: [Pin; 2] = [Pin::new(GPIOA, 1), Pin::new(GPIOA, 7)];

/// TIM1: channel 3 forced, and what breaks it.
fn breaks() {
    // A wire that is broken is a stop.
    STOP.alternate(TIM1_FUNCTION, Pupdr::PULL_DOWN);
    // DBGMCU_APB2FZR (47.6.7) with 28.3.31: outputs are off while a debugger has halted the processor.
    DBGMCU.apb2fzr().modify(|w| w.set_tim1(true));
    // CCMR2.OC3M (28.6.10): forced inactive. CR2.OIS3 (28.6.2) is low after reset.
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
    // BDTR (28.6.20): both breaks, high; no filter, so that they need no clock; held low when off, and never on by itself. The lock is the
    // last that can be written.
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

fn force(level: Ocm) {
    TIM1.ccmr_output(1).modify(|w| {
        w.set_ccs(0, CcmrOutputCcs::OUTPUT);
        w.set_ocm(0, level);
    });
}

/// What the block interrupt learns of the breaks.
pub struct Broken {
    /// The comparators have dropped the enable since the last look.
    pub over_current: bool,
    /// The enable is down since a break: play mid-code.
    pub cut: bool,
}

/// Looks at the flags of the breaks, and clears them: TIM1_SR.BIF, B2IF (28.6.5). One whose input still stands is set again at once.
pub fn look() -> Broken {
    let flags = TIM1.sr().read();
    let (over_current, stopped) = (flags.bif(BREAK), flags.bif(BREAK_2));
    if over_current || stopped {
        CUT.store(true, Ordering::Relaxed);
        // Zero clears, one keeps.
        let mut keep = SrAdv(u32::MAX);
        keep.set_bif(BREAK, !over_current);
        keep.set_bif(BREAK_2, !stopped);
        TIM1.sr().write_value(keep);
    }
    Broken { over_current, cut: CUT.load(Ordering::Relaxed) }
}

/// Drops the enable, from anywhere, for good: what drives it again must order it low first. TIM1_BDTR.MOE (28.6.20).
pub fn drop_enable() {
    CUT.store(true, Ordering::Relaxed);
    TIM1.bdtr().modify(|w| w.set_moe(false));
}

/// The amplifier's enable. After a break it stays low until it was set low.
pub struct Enable {
    high: bool,
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
        // Only the edge arms it: it is set again at every turn, and must not undo a break by that.
        if !self.high {
            self.high = true;
            force(Ocm::FORCE_ACTIVE);
            // A break whose input still stands keeps this from being set.
            TIM1.bdtr().modify(|w| w.set_moe(true));
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
