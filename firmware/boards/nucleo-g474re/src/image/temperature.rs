//! Temperature, measured ten times a second: ADC5 measures the processor, ADC4 a thermistor at the
//! heat sink if there is one. The hotter one counts. RM0440 21.4.31 (sensor), 21.4.33 (reference).
//!
//! Sensor and reference need at least 5 us of sampling (DS12288); [`adc::convert`] takes 15 us.
#![expect(unsafe_code, reason = "the factory's calibration is read from its address")]

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

/// Input of the sensor: ADC5_IN4 (RM0440 21.4.11, table of inputs).
const SENSOR: u8 = 4;
/// Input of the reference: ADC5_IN18 (RM0440 21.4.11, table of inputs).
const REFERENCE: u8 = 18;
/// Input of the thermistor: ADC4_IN4 is PB14 (DS12288, pin description).
const THERMISTOR: u8 = 4;
/// Address of the factory's code of the sensor at 30 degrees Celsius (DS12288).
const TS_CAL1: *const u16 = 0x1fff_75a8 as *const u16;
/// Address of the factory's code of the sensor at 130 degrees Celsius (DS12288).
const TS_CAL2: *const u16 = 0x1fff_75ca as *const u16;
/// Address of the factory's code of the reference (DS12288).
const VREFINT_CAL: *const u16 = 0x1fff_75aa as *const u16;
/// Time between two measurements, cycles: a tenth of a second.
const PERIOD_CYCLES: u32 = 100_000 * CYCLES_PER_US;

/// Latest temperature, as the bits of a value in degrees Celsius.
static LATEST_C_BITS: AtomicU32 = AtomicU32::new(0);

/// Returns the latest temperature, degrees Celsius. It is measured for the first time before the
/// first block.
pub fn latest() -> f32 {
    f32::from_bits(LATEST_C_BITS.load(Ordering::Relaxed))
}

/// Temperature measurement of the processor and the heat sink.
pub struct Thermometer {
    calibration: Calibration,
    thermistor: Option<Thermistor>,
    measured: u32,
}

impl Thermometer {
    /// Starts the sensor and its ADC, and the ADC of a thermistor.
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
        // t_START of the sensor is at most 120 us (DS12288).
        delay(120 * CYCLES_PER_US);
        // SAFETY: reads three aligned half-words of read-only memory.
        let [low, high, reference] = [TS_CAL1, TS_CAL2, VREFINT_CAL].map(|at| unsafe { at.read_volatile() });
        let mut thermometer = Thermometer { calibration: Calibration { low, high, reference }, thermistor, measured: 0 };
        thermometer.measure();
        thermometer
    }

    /// Measures if a measurement is due, which takes 60 us, and 30 us more with a thermistor.
    pub fn poll(&mut self) {
        if DWT::cycle_count().wrapping_sub(self.measured) >= PERIOD_CYCLES {
            self.measure();
        }
    }

    fn measure(&mut self) {
        self.measured = DWT::cycle_count();
        let own = celsius(&self.calibration, adc::convert(ADC5, SENSOR), adc::convert(ADC5, REFERENCE));
        let hottest = self.thermistor.map_or(own, |thermistor| thermistor.celsius(adc::convert(ADC4, THERMISTOR)).max(own));
        LATEST_C_BITS.store(hottest.to_bits(), Ordering::Relaxed);
    }
}
