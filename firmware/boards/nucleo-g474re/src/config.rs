//! Front end of this board, and the configuration of its controller.
//!
//! ```text
//! drive:   code -> 3.3 V / 4096 about mid-scale -> amplifier, 10 V/V
//! voltage: stack -> divider, 1/12.5 -> mid-scale -> two conversions, summed
//! current: stack -> 0.1 ohm -> 4 V/V -> mid-scale -> two conversions, summed
//! ```
//!
//! The supply of the converters is assumed to be 3.3 V. `docs/board.md` has the circuit.

use firmware::seam::block::Amplitude;
use firmware::seam::config::{
    self, Burst, Config, Drive, FrontEnd, HeatSink, Limits, Phasing, Supply, Sweep, Thermometer, Tracking,
};

use crate::blocks::BLOCK;

/// Reference voltage of the converters, V.
pub const REFERENCE_V: f32 = 3.3;
/// Number of codes of a converter.
pub const CODES: f32 = 4096.0;
/// Gain from the DAC to the stack, V/V.
pub const AMPLIFIER: f32 = 10.0;
/// Ratio of the voltage at the stack to the voltage at the ADC, V/V.
pub const DIVIDER: f32 = 12.5;
/// Voltage at the ADC per current, V/A: a shunt of 0.1 ohm, amplified four times.
pub const TRANSIMPEDANCE: f32 = 0.4;
/// Number of conversions in a sample.
pub const CONVERSIONS: u16 = 2;
/// Largest current at which the comparators drop the amplifier's enable, A peak. It is above the
/// largest limit of the controller.
pub const TRIP_A: f32 = 3.5;
/// Default number of drive lanes: one or two play from DAC1, three or four from DAC3 and DAC4
/// through the op-amps.
const LANES: u8 = 1;

/// Number of conversions that the force channel adds up per reading.
pub const FORCE_CONVERSIONS: u16 = 16;

/// Longest permitted silence of the host while the drive is on, s.
pub const PATIENCE_S: f32 = 1.0;

/// DAC code of zero volts.
pub const SILENCE: u16 = 2048;

/// Returns the configuration that is built into the image.
///
/// The settings replace the values that differ between circuits: scale factors, lanes, sensors,
/// limits.
pub fn config() -> Config {
    let sense_volt_per_lsb = REFERENCE_V / CODES / f32::from(CONVERSIONS);
    Config {
        sample_hz: 1e6,
        block_samples: BLOCK as u16,
        lanes: LANES,
        front_end: FrontEnd {
            volt_per_lsb: sense_volt_per_lsb * DIVIDER,
            ampere_per_lsb: sense_volt_per_lsb / TRANSIMPEDANCE,
            sense_mid_code: CONVERSIONS * 2048,
            sense_max_code: CONVERSIONS * 4095,
            drive_volt_per_lsb: REFERENCE_V / CODES * AMPLIFIER,
            drive_mid_code: SILENCE,
            drive_max_code: 4095,
            drive_lanes: 4,
            metre_per_count: None,
            force_hz: None,
            newton_per_lsb: None,
        },
        drive: Drive::sine(40e3, Amplitude::Volts(3.0), 1.0),
        sweep: Sweep::Hold,
        phasing: Phasing::default(),
        burst: Burst::default(),
        tracking: Tracking { span: 0.05, bandwidth_hz: 200.0, nominal_c0_f: Some(300e-9), ..Tracking::new(50.0) },
        thermometer: Thermometer::default(),
        heat_sink: HeatSink::default(),
        supply: Supply::default(),
        limits: Limits { temperature_c: 85.0, ..Limits::default() },
        friction: None,
        restraint: None,
        link: config::Link { patience_s: PATIENCE_S },
    }
}

/// Returns the threshold codes of the two comparators for a current, A peak, on either side of
/// zero. They are clipped to the converter's range.
pub fn trip_codes(ampere: f32) -> (u16, u16) {
    let codes = ampere * TRANSIMPEDANCE / REFERENCE_V * CODES;
    let middle = f32::from(SILENCE);
    ((middle + codes).clamp(0.0, CODES - 1.0) as u16, (middle - codes).clamp(0.0, CODES - 1.0) as u16)
}

/// Returns the largest current that the current channel measures without clipping, A peak.
pub fn range_a() -> f32 {
    REFERENCE_V / 2.0 / TRANSIMPEDANCE
}

/// Returns the force of a reading of the force channel, N. The reading is the sum of its
/// conversions; mid-scale is zero force.
pub fn force_n(code: u16, newton_per_lsb: f32) -> f32 {
    (f32::from(code) - f32::from(FORCE_CONVERSIONS * SILENCE)) * newton_per_lsb
}
