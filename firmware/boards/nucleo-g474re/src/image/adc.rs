//! Simultaneous sampling of `V` and `I`: ADC1 and ADC2 in dual regular simultaneous mode, two
//! conversions summed in hardware. RM0440 21.
//!
//! At 42.5 MHz a conversion takes 3.5 + 12.5 cycles, 376 ns. Two fit into a sample of 1 us, 500 ns
//! apart, with a margin of three cycles
//! ([`MARGIN_EIGHTHS`](nucleo_g474re::sampling::MARGIN_EIGHTHS)).
//!
//! Two more ADCs, staggered by 250 ns, would give four conversions and 3 dB less noise. On this
//! family, however, conversions that start at different instants disturb each other, according to
//! user reports. The noise of a sample does not limit the tracker, so one pair is used.
//!
//! A sample is one word, ADC_CDR: `V` and `I`, each a sum of 13 bits.
#![expect(unsafe_code, reason = "enabling an interrupt is unsafe")]

use boards_common::position::position;
use cortex_m::asm::delay;
use cortex_m::peripheral::NVIC;
use nucleo_g474re::blocks::RING;
use nucleo_g474re::trips::Levels;
use stm32_metapac::adc::Adc;
use stm32_metapac::adc::vals::{Adcaldif, Exten, Ovrmod, SampleTime, Trovs};
use stm32_metapac::adccommon::vals::{Ckmode, Dmacfg, Dual, Mdma};
use stm32_metapac::bdma::vals::Pl;
use stm32_metapac::gpio::vals::Pupdr;
use stm32_metapac::{ADC1, ADC2, ADC12_COMMON, GPIOA, Interrupt, interrupt};

use super::clocks::CYCLES_PER_US;
use super::dma::{Channel, Direction, Ring};
use super::panic;
use super::pins::Pin;
use super::protection::CURRENT;

/// Ring of samples that DMA fills.
pub static SAMPLES: Ring<u32, RING> = Ring::new(0);
/// DMA channel of the samples.
pub const CHANNEL: Channel = Channel::of_dma1(0);

/// Input of `V`: ADC1_IN1, PA0, a fast input (DS12288, pin description).
const V_CHANNEL: u8 = 1;
/// Input of `I`: ADC2_IN2, PA1, a fast input (DS12288, pin description).
const I_CHANNEL: u8 = 2;
/// Input of the current at the negative trip: ADC2_IN4, PA7 (DS12288, pin description).
const NEGATIVE_CHANNEL: u8 = 4;
/// DMA request number of ADC1 (RM0440 13.3.2, table of requests).
const REQUEST: u8 = 5;
/// Number of TIM4_TRGO among the triggers of the regular group of ADC1 and ADC2 (RM0440 21.4.18).
const TRIGGER: u8 = 12;

/// Calibrates both ADCs and returns the current at rest, measured at both pins of the over-current
/// trips.
///
/// Both pins are pulled down before the measurement, so that an unconnected pin stays near zero.
pub fn levels() -> Levels {
    // ADCx_CCR (21.8.2), while both are off: the clock is HCLK / 4.
    ADC12_COMMON.ccr().write(|w| w.set_ckmode(Ckmode::SYNC_DIV4));
    calibrate(ADC1);
    calibrate(ADC2);
    enable(ADC2);
    let [positive, negative] = [(CURRENT[0], I_CHANNEL), (CURRENT[1], NEGATIVE_CHANNEL)].map(|(pin, channel)| {
        pin.input(Pupdr::PULL_DOWN);
        delay(10 * CYCLES_PER_US);
        pin.analog();
        delay(10 * CYCLES_PER_US);
        convert(ADC2, channel)
    });
    // ADC_CR.ADDIS (21.7.3): off again, because the dual mode may be set only while both are off.
    ADC2.cr().modify(|w| w.set_addis(true));
    while ADC2.cr().read().aden() {}
    Levels { positive, negative }
}

/// Makes both ADCs wait for their trigger. Must be called after [`levels`].
pub fn start() {
    Pin::new(GPIOA, 0).analog();
    // ADCx_CCR (21.8.2), while both are off: HCLK / 4; regular simultaneous; words of both, by DMA,
    // in a ring.
    ADC12_COMMON.ccr().write(|w| {
        w.set_ckmode(Ckmode::SYNC_DIV4);
        w.set_dual(Dual::DUAL_R);
        w.set_mdma(Mdma::ENABLED12B10B);
        w.set_dmacfg(Dmacfg::CIRCULAR);
    });
    for (adc, channel) in [(ADC1, V_CHANNEL), (ADC2, I_CHANNEL)] {
        // One after the other: on this family, two ADCs that wake at the same time disturb each
        // other.
        enable(adc);
        sequence(adc, channel, SampleTime::CYCLES2_5);
        // ADC_SMPR1.SMPPLUS (21.7.6): 3.5 cycles of sampling instead of 2.5.
        adc.smpr().modify(|w| w.set_smpplus(true));
        // ADC_CFGR2 (21.7.5): sums of two, not shifted, one trigger per conversion. The same for
        // both, as dual mode requires (21.4.30).
        adc.cfgr2().modify(|w| {
            w.set_ovsr(0);
            w.set_ovss(0);
            w.set_trovs(Trovs::TRIGGERED);
            w.set_rovse(true);
        });
    }
    for adc in [ADC1, ADC2] {
        // ADC_CFGR.OVRMOD (21.7.4): without the FIFO of ADC_DR, in which the values of the slave
        // may be shifted against those of the master when one DMA channel reads both (ES0430
        // 2.7.6). OVR is set all the same.
        adc.cfgr().modify(|w| w.set_ovrmod(Ovrmod::OVERWRITE));
        // ADC_IER.OVRIE (21.7.2): DMA stops if a sample is lost (21.4.26), and no further block
        // would report it.
        adc.ier().modify(|w| w.set_ovrie(true));
    }
    // SAFETY: the handler uses only registers and the note.
    unsafe { NVIC::unmask(Interrupt::ADC1_2) };
    // ADC_CFGR.EXTSEL, EXTEN (21.7.4): the slave follows the master.
    ADC1.cfgr().modify(|w| {
        w.set_extsel(TRIGGER);
        w.set_exten(Exten::RISING_EDGE);
    });
    CHANNEL.start(REQUEST, ADC12_COMMON.cdr().as_ptr().cast(), &SAMPLES, Direction::InWithInterrupts, Pl::VERY_HIGH);
    // ADC_CR.ADSTART (21.7.3) of the master: it now waits for the trigger.
    ADC1.cr().modify(|w| w.set_adstart(true));
}

/// Returns the place in the ring that DMA fills next.
pub fn next() -> usize {
    position::<RING>(CHANNEL.remaining().into())
}

/// Ends the blocks, because a sample was lost.
#[interrupt]
fn ADC1_2() {
    panic::end_blocks();
}

/// Returns `true` if a conversion was lost, which stops DMA: ADC_ISR.OVR (21.7.1).
pub fn is_overrun() -> bool {
    ADC1.isr().read().ovr() || ADC2.isr().read().ovr()
}

/// Wakes an ADC and calibrates it, single-ended: RM0440 21.4.6 and 21.4.8.
pub fn calibrate(adc: Adc) {
    // ADC_CR.DEEPPWD, ADVREGEN (21.7.3); the regulator takes 20 us (DS12288, ADC characteristics).
    adc.cr().modify(|w| w.set_deeppwd(false));
    adc.cr().modify(|w| w.set_advregen(true));
    delay(25 * CYCLES_PER_US);
    adc.cr().modify(|w| {
        w.set_adcaldif(Adcaldif::SINGLE_ENDED);
        w.set_adcal(true);
    });
    while adc.cr().read().adcal() {}
    // The ADC may be enabled four of its cycles after the calibration (21.4.8).
    delay(CYCLES_PER_US);
}

/// Wakes, calibrates and enables an ADC, unless it is enabled already.
pub fn wake(adc: Adc) {
    if !adc.cr().read().aden() {
        calibrate(adc);
        enable(adc);
    }
}

/// Enables an ADC and waits until it is ready: ADC_ISR.ADRDY (21.7.1), ADC_CR.ADEN (21.7.3), RM0440
/// 21.4.9.
pub fn enable(adc: Adc) {
    adc.isr().write(|w| w.set_adrdy(true));
    adc.cr().modify(|w| w.set_aden(true));
    while !adc.isr().read().adrdy() {}
}

/// Selects one conversion, of this channel: ADC_SQR1 (21.7.11), ADC_SMPR1 and 2 (21.7.6, 21.7.7).
pub fn sequence(adc: Adc, channel: u8, time: SampleTime) {
    adc.sqr1().write(|w| {
        w.set_l(0);
        w.set_sq(0, channel);
    });
    let number = usize::from(channel);
    if number < 10 {
        adc.smpr().modify(|w| w.set_smp(number, time));
    } else {
        adc.smpr2().modify(|w| w.set_smp(number - 10, time));
    }
}

/// Returns the result of a conversion with a sampling time of 640.5 cycles, 15 us.
///
/// A first conversion is discarded: a conversion that follows another one after a long time is
/// wrong on this part (ES0430).
pub fn convert(adc: Adc, channel: u8) -> u16 {
    sequence(adc, channel, SampleTime::CYCLES640_5);
    let once = || {
        // ADC_CR.ADSTART (21.7.3) clears itself; reading ADC_DR clears ADC_ISR.EOC (21.7.1,
        // 21.7.16).
        adc.cr().modify(|w| w.set_adstart(true));
        while !adc.isr().read().eoc() {}
        while adc.cr().read().adstart() {}
        adc.dr().read().0 as u16
    };
    once();
    once()
}
