//! The temperature, a few times a second: the processor's own by ADC5 and, where there is a thermistor at the heat sink, the hotter of the two;
//! that one by ADC4. RM0440 21.4.31 (sensor), 21.4.33 (reference).
//!
//! Sensor and reference want 5 us of sampling at least (DS12288); [`adc::convert`] takes 15 us.
#![expect(unsafe_code, reason = "the factory's calibration is read from its place")]

use core::sync::atomic::{AtomicU32, Ordering};

use boards_common::thermistor::Thermistor;
use cortex_m::asm::delay;
use cortex_m::peripheral::DWT;
use nucleo_g474re::degrees::{Calibration, celsius};
use stm32_metapac::adccommon::vals::Ckmode;
use stm32_metapac::{ADC4, ADC5, ADC345_COMMON, GPIOB};

use super::adc;
use super::clocks::CYCLES_PER_US;
use super::pins::Pin;

/// ADC5_IN4 is the sensor, ADC5_IN18 the reference (RM0440 21.4.11, table of inputs).
const SENSOR: u8 = 4;
const REFERENCE: u8 = 18;
/// ADC4_IN4 is PB14 (DS12288, pin description).
const THERMISTOR: u8 = 4;
/// Addresses of the factory's measurements (DS12288: TS_CAL1, TS_CAL2, VREFINT_CAL).
const TS_CAL1: *const u16 = 0x1fff_75a8 as *const u16;
const TS_CAL2: *const u16 = 0x1fff_75ca as *const u16;
const VREFINT_CAL: *const u16 = 0x1fff_75aa as *const u16;
/// Cycles between two measurements: a tenth of a second.
const EVERY: u32 = 100_000 * CYCLES_PER_US;

/// The latest temperature, as bits of degrees Celsius.
static LATEST: AtomicU32 = AtomicU32::new(0);

/// The latest measurement, degrees Celsius; there is one before the first block.
pub fn latest() -> f32 {
    f32::from_bits(LATEST.load(Ordering::Relaxed))
}

/// The sensor.
pub struct Thermometer {
    calibration: Calibration,
    thermistor: Option<Thermistor>,
    measured: u32,
}

impl Thermometer {
    /// Starts the sensor and its ADC, and that of a thermistor.
    pub fn start(thermistor: Option<Thermistor>) -> Self {
        // ADCx_CCR (21.8.2), while its ADCs are off: HCLK / 4, sensor and reference on.
        ADC345_COMMON.ccr().write(|w| {
            w.set_ckmode(Ckmode::SYNC_DIV4);
            w.set_vsenseen(true);
            w.set_vrefen(true);
        });
        adc::wake(ADC5);
        if thermistor.is_some() {
            Pin::new(GPIOB, 14).analog();
            adc::wake(ADC4);
        }
        // t_START of the sensor is 120 us at most (DS12288).
        delay(120 * CYCLES_PER_US);
        // SAFETY: three aligned half-words of the part's read-only memory.
        let [low, high, reference] = [TS_CAL1, TS_CAL2, VREFINT_CAL].map(|at| unsafe { at.read_volatile() });
        let mut thermometer = Thermometer { calibration: Calibration { low, high, reference }, thermistor, measured: 0 };
        thermometer.measure();
        thermometer
    }

    /// Measures when a measurement is due; 60 us of waiting then, and 30 us more with a thermistor.
    pub fn poll(&mut self) {
        if DWT::cycle_count().wrapping_sub(self.measured) >= EVERY {
            self.measure();
        }
    }

    fn measure(&mut self) {
        self.measured = DWT::cycle_count();
        let own = celsius(&self.calibration, adc::convert(ADC5, SENSOR), adc::convert(ADC5, REFERENCE));
        let hottest = self.thermistor.map_or(own, |thermistor| thermistor.celsius(adc::convert(ADC4, THERMISTOR)).max(own));
        LATEST.store(hottest.to_bits(), Ordering::Relaxed);
    }
}
