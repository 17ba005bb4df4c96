//! Supply voltage of the amplifier: ADC4 measures PB15 a hundred times a second. `supply.rs`
//! watches the processor's own supply.

use core::sync::atomic::{AtomicBool, Ordering};

use boards_common::supply_window::SupplyWindow;
use cortex_m::peripheral::DWT;
use stm32_metapac::{ADC4, GPIOB};

use super::adc;
use super::clocks::CYCLES_PER_US;
use super::pins::Pin;

/// Input of the amplifier's supply: ADC4_IN5 is PB15 (DS12288, pin description).
const CHANNEL: u8 = 5;
/// Time between two measurements, cycles: 10 ms.
const PERIOD_CYCLES: u32 = 10_000 * CYCLES_PER_US;

/// `true` if the latest measurement was outside the permitted range.
static IS_OUT: AtomicBool = AtomicBool::new(false);

/// Returns `true` if the latest measurement was outside the permitted range.
pub fn is_out() -> bool {
    IS_OUT.load(Ordering::Relaxed)
}

/// Periodic measurement of the amplifier's supply.
pub struct AmplifierSupply {
    window: Option<SupplyWindow>,
    measured: u32,
}

impl AmplifierSupply {
    /// Measures for the first time. If there is no permitted range, it never measures. The clock of
    /// ADC3 to ADC5 must be set before (`temperature.rs`).
    pub fn start(window: Option<SupplyWindow>) -> Self {
        if window.is_some() {
            Pin::new(GPIOB, 15).analog();
            adc::wake(ADC4);
        }
        let mut supply = AmplifierSupply { window, measured: 0 };
        supply.measure();
        supply
    }

    /// Measures if a measurement is due, which takes 30 us.
    pub fn poll(&mut self) {
        if DWT::cycle_count().wrapping_sub(self.measured) >= PERIOD_CYCLES {
            self.measure();
        }
    }

    fn measure(&mut self) {
        self.measured = DWT::cycle_count();
        if let Some(window) = &self.window {
            IS_OUT.store(!window.holds(adc::convert(ADC4, CHANNEL)), Ordering::Relaxed);
        }
    }
}
