//! Data that the factory has written: RM0440 48, DS12288 (calibration values).

use cortex_m4::Memory;

use crate::part::Config;

/// Raw reading of the temperature sensor at 30 °C and a supply of 3.0 V, typical (DS12288).
pub const TS_CAL1: u32 = 1035;
/// Raw reading of the temperature sensor at 130 °C and a supply of 3.0 V, typical (DS12288).
pub const TS_CAL2: u32 = 1376;
/// Raw reading of the reference at a supply of 3.0 V, typical (DS12288).
pub const VREFINT_CAL: u32 = 1655;
/// Supply of these readings, V.
const CALIBRATED_AT: f64 = 3.0;

/// Returns the word at an address of the factory area; `None` for unknown words.
pub fn read(address: u32, config: &Config) -> Option<u32> {
    match address {
        0x1fff_75a8 => Some(VREFINT_CAL << 16 | TS_CAL1),
        0x1fff_75c8 => Some(TS_CAL2 << 16),
        0x1fff_7590 => Some(config.id[0]),
        0x1fff_7594 => Some(config.id[1]),
        0x1fff_7598 => Some(config.id[2]),
        // Package (LQFP64) and size of the flash, KiB.
        0x1fff_7500 => Some(0),
        0x1fff_75e0 => Some(512),
        _ => None,
    }
}

/// Device of this microcontroller, DBGMCU_IDCODE.DEV_ID (RM0440 47.6.1).
const DEVICE: u32 = 0x469;

/// Returns DBGMCU_IDCODE: the silicon revision above the device.
pub fn idcode(config: &Config) -> u32 {
    u32::from(config.revision) << 16 | DEVICE
}

/// Returns the voltage of the temperature sensor, V.
pub fn sensor_volts(celsius: f64) -> f64 {
    let codes = f64::from(TS_CAL1) + (celsius - 30.0) / 100.0 * f64::from(TS_CAL2 - TS_CAL1);
    codes / 4096.0 * CALIBRATED_AT
}

/// Returns the voltage of the internal reference, V.
pub fn reference_volts() -> f64 {
    f64::from(VREFINT_CAL) / 4096.0 * CALIBRATED_AT
}

/// Fills the RAM with its bits after power-on: arbitrary, but identical each time.
pub fn scramble(memory: &mut Memory) {
    for (base, len) in [(0x2000_0000, 0x1_8000), (0x1000_0000, 0x8000)] {
        let mut state = 0x9e37_79b9_u32;
        for byte in memory.get_mut(base, len).unwrap_or_default() {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *byte = (state >> 24) as u8;
        }
    }
}
