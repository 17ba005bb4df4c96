//! `V` and `I` at the same instants: ADC1 and ADC2 in dual regular simultaneous mode, two conversions summed in hardware. RM0440 21.
//!
//! At 42.5 MHz a conversion takes 3.5 + 12.5 cycles, 376 ns, so that two fit into a sample of 1 us, 500 ns apart, with a margin of three cycles
//! ([`MARGIN`](nucleo_g474re::sampling::MARGIN)). Two more ADCs, staggered by 250 ns, would give four and 3 dB less noise, but conversions of
//! other ADCs at other instants disturb those under way on this family (as its users report), and the noise of a sample is not
//! what limits the tracker: one pair.
//!
//! What a sample is: `V` and `I` as two sums of 13 bits in one word, ADC_CDR.
#![expect(unsafe_code, reason = "enabling an interrupt is")]

use boards_common::position::position;
use cortex_m::asm::delay;
use cortex_m::peripheral::NVIC;
use nucleo_g474re::blocks::RING;
use nucleo_g474re::trips::Levels;
use stm32_metapac::adc::Adc;
use stm32_metapac::adc::vals::{Adcaldif, Exten, SampleTime, Trovs};
use stm32_metapac::adccommon::vals::{Ckmode, Dmacfg, Dual, Mdma};
use stm32_metapac::bdma::vals::Pl;
use stm32_metapac::gpio::vals::Pupdr;
use stm32_metapac::{ADC1, ADC2, ADC12_COMMON, GPIOA, Interrupt, interrupt};

use super::clocks::CYCLES_PER_US;
use super::dma::{Channel, Ring, Way};
use super::panic;
use super::pins::Pin;
use super::protection::CURRENT;

/// The samples that DMA leaves.
pub static SAMPLES: Ring<u32, RING> = Ring::new(0);
/// The DMA channel of the samples.
pub const CHANNEL: Channel = Channel::of_first(0);

/// ADC1_IN1, PA0, `V`; ADC2_IN2, PA1, `I`: both of the fast inputs (DS12288, pin description).
const V_CHANNEL: u8 = 1;
const I_CHANNEL: u8 = 2;
/// ADC2_IN4, PA7: the current again, at the negative trip (DS12288, pin description).
const NEGATIVE_CHANNEL: u8 = 4;
/// Request of ADC1 (RM0440 13.3.2, table of requests).
const REQUEST: u8 = 5;
/// TIM4_TRGO among the triggers of the regular group of ADC1 and ADC2 (RM0440 21.4.18).
const TRIGGER: u8 = 12;

/// Calibrates both, and returns the current at rest, at both pins of the over-current trips.
///
/// The pins are pulled down before: a pin that nothing drives stays near zero.
pub fn levels() -> Levels {
    // ADCx_CCR (21.8.2), while both are off: HCLK / 4.
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
    // ADC_CR.ADDIS (21.7.3): off again, as the dual mode is set while both are.
    ADC2.cr().modify(|w| w.set_addis(true));
    while ADC2.cr().read().aden() {}
    Levels { positive, negative }
}

/// Makes both wait for their trigger, after [`levels`].
pub fn start() {
    Pin::new(GPIOA, 0).analog();
    // ADCx_CCR (21.8.2), while both are off: HCLK / 4; regular simultaneous; words of both, by DMA, in a ring.
    ADC12_COMMON.ccr().write(|w| {
        w.set_ckmode(Ckmode::SYNC_DIV4);
        w.set_dual(Dual::DUAL_R);
        w.set_mdma(Mdma::ENABLED12B10B);
        w.set_dmacfg(Dmacfg::CIRCULAR);
    });
    for (adc, channel) in [(ADC1, V_CHANNEL), (ADC2, I_CHANNEL)] {
        // One after the other: two that wake at once disturb each other on this family.
        enable(adc);
        sequence(adc, channel, SampleTime::CYCLES2_5);
        // ADC_SMPR1.SMPPLUS (21.7.6): 2.5 cycles are 3.5.
        adc.smpr().modify(|w| w.set_smpplus(true));
        // ADC_CFGR2 (21.7.5): sums of two, not shifted, each by a trigger of its own. Both alike, as dual mode asks (21.4.30).
        adc.cfgr2().modify(|w| {
            w.set_ovsr(0);
            w.set_ovss(0);
            w.set_trovs(Trovs::TRIGGERED);
            w.set_rovse(true);
        });
    }
    for adc in [ADC1, ADC2] {
        // ADC_IER.OVRIE (21.7.2): where a sample is lost, DMA stops (21.4.26), and no block would come to say so.
        adc.ier().modify(|w| w.set_ovrie(true));
    }
    // SAFETY: the handler needs nothing but registers and the note.
    unsafe { NVIC::unmask(Interrupt::ADC1_2) };
    // ADC_CFGR.EXTSEL, EXTEN (21.7.4): the slave follows the master.
    ADC1.cfgr().modify(|w| {
        w.set_extsel(TRIGGER);
        w.set_exten(Exten::RISING_EDGE);
    });
    CHANNEL.start(REQUEST, ADC12_COMMON.cdr().as_ptr().cast(), &SAMPLES, Way::InWithInterrupts, Pl::VERY_HIGH);
    // ADC_CR.ADSTART (21.7.3) of the master: now it waits.
    ADC1.cr().modify(|w| w.set_adstart(true));
}

/// The place in the ring that is filled next.
pub fn next() -> usize {
    position::<RING>(CHANNEL.remaining().into())
}

/// A sample was lost.
#[interrupt]
fn ADC1_2() {
    panic::end_blocks();
}

/// Whether a conversion was lost, which stops DMA: ADC_ISR.OVR (21.7.1).
pub fn is_overrun() -> bool {
    ADC1.isr().read().ovr() || ADC2.isr().read().ovr()
}

/// Wakes an ADC and calibrates it, single-ended: RM0440 21.4.6 and 21.4.8.
pub fn calibrate(adc: Adc) {
    // ADC_CR.DEEPPWD, ADVREGEN (21.7.3); its regulator takes 20 us (DS12288, ADC characteristics).
    adc.cr().modify(|w| w.set_deeppwd(false));
    adc.cr().modify(|w| w.set_advregen(true));
    delay(25 * CYCLES_PER_US);
    adc.cr().modify(|w| {
        w.set_adcaldif(Adcaldif::SINGLE_ENDED);
        w.set_adcal(true);
    });
    while adc.cr().read().adcal() {}
    // Four of its cycles before it may be enabled (21.4.8).
    delay(CYCLES_PER_US);
}

/// Wakes, calibrates and enables an ADC, once.
pub fn wake(adc: Adc) {
    if !adc.cr().read().aden() {
        calibrate(adc);
        enable(adc);
    }
}

/// Enables an ADC and waits until it is ready: ADC_ISR.ADRDY (21.7.1), ADC_CR.ADEN (21.7.3), RM0440 21.4.9.
pub fn enable(adc: Adc) {
    adc.isr().write(|w| w.set_adrdy(true));
    adc.cr().modify(|w| w.set_aden(true));
    while !adc.isr().read().adrdy() {}
}

/// One conversion, of this channel: ADC_SQR1 (21.7.11), ADC_SMPR1 and 2 (21.7.6, 21.7.7).
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

/// The result of a conversion of 640.5 cycles of sampling, 15 us. The one before it does not count: a conversion that comes late after another one is
/// wrong on this part (ES0430).
pub fn convert(adc: Adc, channel: u8) -> u16 {
    sequence(adc, channel, SampleTime::CYCLES640_5);
    let once = || {
        // ADC_CR.ADSTART (21.7.3), which clears itself, ADC_ISR.EOC, which reading ADC_DR clears (21.7.1, 21.7.16).
        adc.cr().modify(|w| w.set_adstart(true));
        while !adc.isr().read().eoc() {}
        while adc.cr().read().adstart() {}
        adc.dr().read().0 as u16
    };
    once();
    once()
}
