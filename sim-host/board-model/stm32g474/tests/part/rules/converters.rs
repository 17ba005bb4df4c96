//! Rules of ADC, DAC and DMA.

use sonoglide_stm32g474::map::at;
use sonoglide_stm32g474::map::base::*;
use sonoglide_stm32g474::{Bare, Rule};

use super::{check, up};
use crate::rig::{ADC_RING, DAC_RING, Rig, Setup};

/// Enables the clock of ADC1.
fn adc_clock(rig: &mut Rig<Bare>) {
    up(rig);
    rig.write(ADC12_COMMON + at::adccommon::CCR, 3 << 16);
}

#[test]
fn adc_power() {
    check(
        Rule::AdcPower,
        |rig| {
            adc_clock(rig);
            rig.wake_adc(ADC1);
        },
        |rig| {
            adc_clock(rig);
            rig.write(ADC1 + at::adc::CR, 3 << 28);
        },
    );
}

#[test]
fn adc_regulator() {
    fn start(rig: &mut Rig<Bare>, us: u64) {
        adc_clock(rig);
        rig.write(ADC1 + at::adc::CR, 0);
        rig.write(ADC1 + at::adc::CR, 1 << 28);
        rig.us(us);
        rig.set(ADC1 + at::adc::CR, 1 << 31);
    }
    check(Rule::AdcRegulator, |rig| start(rig, 20), |rig| start(rig, 19));
}

#[test]
fn adc_calibration() {
    fn enable(rig: &mut Rig<Bare>, calibrates: bool, waits: u64) {
        adc_clock(rig);
        rig.write(ADC1 + at::adc::CR, 0);
        rig.write(ADC1 + at::adc::CR, 1 << 28);
        rig.us(21);
        if calibrates {
            rig.set(ADC1 + at::adc::CR, 1 << 31);
            rig.wait(116 * 4 + 2);
        }
        rig.wait(waits);
        rig.set(ADC1 + at::adc::CR, 1);
    }
    check(Rule::AdcCalibration, |rig| enable(rig, true, 16), |rig| enable(rig, false, 16));
    check(Rule::AdcCalibration, |rig| enable(rig, true, 16), |rig| enable(rig, true, 4));
}

#[test]
fn adc_not_ready() {
    check(
        Rule::AdcNotReady,
        |rig| {
            adc_clock(rig);
            rig.wake_adc(ADC1);
            rig.write(ADC1 + at::adc::SQR1, 1 << 6);
            rig.set(ADC1 + at::adc::CR, 4);
        },
        |rig| {
            adc_clock(rig);
            rig.wake_adc(ADC1);
            rig.write(ADC1 + at::adc::SQR1, 1 << 6);
            // Disabled again.
            rig.set(ADC1 + at::adc::CR, 2);
            rig.set(ADC1 + at::adc::CR, 4);
        },
    );
}

#[test]
fn adc_started() {
    check(
        Rule::AdcStarted,
        |rig| {
            up(rig);
            rig.streams(Setup::default());
            rig.set(ADC1 + at::adc::CR, 1 << 4);
            rig.write(ADC1 + at::adc::SMPR, 3);
        },
        |rig| {
            up(rig);
            rig.streams(Setup::default());
            rig.write(ADC1 + at::adc::SMPR, 3);
        },
    );
}

#[test]
fn adc_common_enabled() {
    check(Rule::AdcCommonEnabled, adc_clock, |rig| {
        adc_clock(rig);
        rig.wake_adc(ADC2);
        rig.write(ADC12_COMMON + at::adccommon::CCR, 2 << 16);
    });
}

#[test]
fn adc_internal_off() {
    fn measure(rig: &mut Rig<Bare>, on: u32) {
        up(rig);
        rig.write(ADC345_COMMON + at::adccommon::CCR, 3 << 16 | on);
        rig.wake_adc(ADC5);
        rig.write(ADC5 + at::adc::SQR1, 4 << 6);
        rig.set(ADC5 + at::adc::CR, 4);
    }
    check(Rule::AdcInternalOff, |rig| measure(rig, 1 << 23), |rig| measure(rig, 0));
}

pub fn stream(rig: &mut Rig<Bare>, setup: Setup) {
    rig.clocks(setup);
    rig.streams(setup);
    rig.us(10);
}

#[test]
fn adc_trigger_lost() {
    // 12.5 + 12.5 ADC cycles, of four core cycles each, are more than the 85 between two triggers.
    check(
        Rule::AdcTriggerLost,
        |rig| stream(rig, Setup::default()),
        |rig| stream(rig, Setup { sampling: 2, ..Setup::default() }),
    );
}

#[test]
fn adc_trigger_margin() {
    // 2.125 + 6.5 + 12.5 ADC cycles, of four core cycles each, are 84.5 of 85.
    check(
        Rule::AdcTriggerMargin,
        |rig| stream(rig, Setup::default()),
        |rig| stream(rig, Setup { sampling: 1, ..Setup::default() }),
    );
}

#[test]
fn adc_dual_fifo() {
    check(
        Rule::AdcDualFifo,
        |rig| stream(rig, Setup::default()),
        |rig| stream(rig, Setup { overwrites: false, ..Setup::default() }),
    );
}

#[test]
fn adc_overrun() {
    check(Rule::AdcOverrun, |rig| stream(rig, Setup::default()), |rig| stream(rig, Setup { adc_dma: false, ..Setup::default() }));
}

#[test]
fn dac_enabled() {
    check(
        Rule::DacEnabled,
        |rig| {
            up(rig);
            rig.write(DAC1 + at::dac::MCR, 2 << 14 | 3);
            rig.write(DAC1 + at::dac::CR, 1);
        },
        |rig| {
            up(rig);
            rig.write(DAC1 + at::dac::MCR, 2 << 14);
            rig.write(DAC1 + at::dac::CR, 1);
            rig.write(DAC1 + at::dac::MCR, 2 << 14 | 3);
        },
    );
}

#[test]
fn dac_bus_clock() {
    check(Rule::DacBusClock, |rig| stream(rig, Setup::default()), |rig| stream(rig, Setup { hfsel: 1, ..Setup::default() }));
}

#[test]
fn dac_underrun() {
    check(
        Rule::DacUnderrun,
        |rig| stream(rig, Setup::default()),
        |rig| stream(rig, Setup { dac_dma: false, ..Setup::default() }),
    );
}

#[test]
fn dma_enabled() {
    fn reprogram(rig: &mut Rig<Bare>, off: bool) {
        up(rig);
        rig.dma(0, 5, ADC12_COMMON + at::adccommon::CDR, ADC_RING, 64, 0x3aa1);
        if off {
            rig.write(DMA1 + at::dma::CH_0_CR, 0);
        }
        rig.write(DMA1 + at::dma::CH_0_MAR, DAC_RING);
    }
    check(Rule::DmaEnabled, |rig| reprogram(rig, true), |rig| reprogram(rig, false));
}

#[test]
fn dma_error() {
    fn play(rig: &mut Rig<Bare>, ring: u32) {
        up(rig);
        rig.streams(Setup::default());
        rig.write(DMA1 + at::dma::CH_1_CR, 0);
        rig.dma(1, 6, DAC1 + at::dac::DHR12RD, ring, 64, 0x2ab1);
        rig.us(1);
    }
    check(Rule::DmaError, |rig| play(rig, DAC_RING), |rig| play(rig, 0x3000_0000));
}
