//! Force channel: ADC3 adds up sixteen conversions of PB0 in each block. RM0440 21.4.30
//! (oversampler).
//!
//! ```text
//! 16 * (47.5 + 12.5) cycles of 42.5 MHz = 22.6 us of a block
//! ```
//!
//! The reading of a block is the sum that the previous block started. Mid-scale is zero force.

use nucleo_g474re::config::{FORCE_CONVERSIONS, force_n};
use stm32_metapac::adc::vals::{SampleTime, Trovs};
use stm32_metapac::{ADC3, GPIOB};

use super::adc;
use super::pins::Pin;

/// Input of the force sensor: ADC3_IN12 is PB0 (DS12288, pin description).
const CHANNEL: u8 = 12;
/// Value n of ADC_CFGR2.OVSR (21.7.5) for 2^(n + 1) conversions.
const OVERSAMPLING: u8 = 3;
const _: () = assert!(FORCE_CONVERSIONS == 1 << (OVERSAMPLING + 1));

/// Force channel with its latest reading.
pub struct ForceChannel {
    newton_per_lsb: f32,
    latest_n: Option<f32>,
}

impl ForceChannel {
    /// Starts the channel. The clock of ADC3 to ADC5 must be set before (`temperature.rs`). The
    /// first reading comes with the second block.
    pub fn start(newton_per_lsb: f32) -> Self {
        Pin::new(GPIOB, 0).analog();
        adc::wake(ADC3);
        adc::sequence(ADC3, CHANNEL, SampleTime::CYCLES47_5);
        // ADC_CFGR2 (21.7.5): sums of sixteen, not shifted, one trigger for all.
        ADC3.cfgr2().modify(|w| {
            w.set_ovsr(OVERSAMPLING);
            w.set_ovss(0);
            w.set_trovs(Trovs::AUTOMATIC);
            w.set_rovse(true);
        });
        ForceChannel { newton_per_lsb, latest_n: None }
    }

    /// Returns the force, N, and starts the next reading. Returns `None` if the channel has not
    /// finished its conversions.
    ///
    /// Reading ADC_DR clears ADC_ISR.EOC (21.7.1, 21.7.16); ADC_CR.ADSTART (21.7.3).
    pub fn read(&mut self) -> Option<f32> {
        self.latest_n = ADC3.isr().read().eoc().then(|| force_n(ADC3.dr().read().0 as u16, self.newton_per_lsb));
        if !ADC3.cr().read().adstart() {
            ADC3.cr().modify(|w| w.set_adstart(true));
        }
        self.latest_n
    }
}
