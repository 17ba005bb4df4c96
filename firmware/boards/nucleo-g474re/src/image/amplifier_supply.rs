//! The amplifier's supply: PB15 by ADC4, a hundred times a second. The processor's own is watched in `supply.rs`.

use core::sync::atomic::{AtomicBool, Ordering};

use boards_common::supply_window::SupplyWindow;
use cortex_m::peripheral::DWT;
use stm32_metapac::{ADC4, GPIOB};

use super::adc;
use super::clocks::CYCLES_PER_US;
use super::pins::Pin;

/// ADC4_IN5 is PB15 (DS12288, pin description).
const CHANNEL: u8 = 5;
/// Cycles between two measurements: 10 ms.
const EVERY: u32 = 10_000 * CYCLES_PER_US;

/// The latest measurement was out of the window.
static OUT: AtomicBool = AtomicBool::new(false);

/// Whether the latest measurement was out of the window.
pub fn is_out() -> bool {
    OUT.load(Ordering::Relaxed)
}

/// The watch.
pub struct AmplifierSupply {
    window: Option<SupplyWindow>,
    measured: u32,
}

impl AmplifierSupply {
    /// Measures once, after the clock of ADC3 to ADC5 was set (`temperature.rs`); where there is no window, never.
    pub fn start(window: Option<SupplyWindow>) -> Self {
        if window.is_some() {
            Pin::new(GPIOB, 15).analog();
            adc::wake(ADC4);
        }
        let mut supply = AmplifierSupply { window, measured: 0 };
        supply.measure();
        supply
    }

    /// Measures when a measurement is due; 30 us of waiting then.
    pub fn poll(&mut self) {
        if DWT::cycle_count().wrapping_sub(self.measured) >= EVERY {
            self.measure();
        }
    }

    fn measure(&mut self) {
        self.measured = DWT::cycle_count();
        if let Some(window) = &self.window {
            OUT.store(!window.holds(adc::convert(ADC4, CHANNEL)), Ordering::Relaxed);
        }
    }
}
