//! Temperatures: the processor's from the factory's calibration, and the heat sink's from a thermistor.
//!
//! ```text
//! processor   T = (130 - 30) / (TS_CAL2 - TS_CAL1) * (code * VREFINT_CAL / vrefint - TS_CAL1) + 30
//! heat sink   1 / T = 1 / 298.15 + ln(R / R25) / B,    R = R_up code / (4096 - code)                  (T in kelvin)
//! ```
//!
//! RM0440 21.4.31 and 21.4.33: the calibration was taken at 3.0 V, and the internal reference shows the present supply. Valid from -40 to
//! 130 degrees Celsius; the sensor is within some degrees (DS12288). A thermistor is fed by the converters' own supply, which cancels. Its
//! logarithm is micromath's, 6e-5 off above one, which is 0.003 K at most from -40 to 150 degrees Celsius: a thermistor of 1 % is 0.2 K off by
//! itself.

use firmware::seam::config::HeatSink;
use micromath::F32;

/// Temperatures of the calibration, degrees Celsius.
const CALIBRATED_C: (f32, f32) = (30.0, 130.0);
/// Temperatures at which the part can run; a sensor that shows others has failed, degrees Celsius.
const PLAUSIBLE_C: (f32, f32) = (-55.0, 155.0);
/// 0 and 25 degrees Celsius, K.
const ZERO_K: f32 = 273.15;
const NOMINAL_K: f32 = ZERO_K + 25.0;
/// Codes of a converter.
const CODES: f32 = 4096.0;

/// The factory's calibration, codes of 12 bits at 3.0 V.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calibration {
    /// The sensor at 30 degrees Celsius.
    pub low: u16,
    /// The sensor at 130 degrees Celsius.
    pub high: u16,
    /// The internal reference.
    pub reference: u16,
}

/// Degrees Celsius of a sensor's code, beside the code of the internal reference; `None` where that cannot be.
pub fn celsius(calibration: &Calibration, sensor: u16, reference: u16) -> Option<f32> {
    if calibration.high <= calibration.low || reference == 0 {
        return None;
    }
    let at_3_v = f32::from(sensor) * f32::from(calibration.reference) / f32::from(reference);
    let (low, high) = (f32::from(calibration.low), f32::from(calibration.high));
    let celsius = CALIBRATED_C.0 + (CALIBRATED_C.1 - CALIBRATED_C.0) * (at_3_v - low) / (high - low);
    (PLAUSIBLE_C.0..=PLAUSIBLE_C.1).contains(&celsius).then_some(celsius)
}

/// A thermistor of negative coefficient from its input to ground, below a resistor to the converters' supply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermistor {
    /// Its resistance at 25 degrees Celsius, ohm.
    pub ohm_at_25_c: f32,
    /// Its coefficient B, K.
    pub beta_k: f32,
    /// The resistor to the supply, ohm.
    pub pull_up_ohm: f32,
}

impl Thermistor {
    /// The thermistor of the settings; `None` where there is none.
    pub fn of(heat_sink: &HeatSink) -> Option<Self> {
        let HeatSink { ohm_at_25_c, beta_k, pull_up_ohm } = *heat_sink;
        ohm_at_25_c.map(|ohm_at_25_c| Thermistor { ohm_at_25_c, beta_k, pull_up_ohm })
    }

    /// Degrees Celsius of a code of 12 bits. A thermistor that is open or short cannot be distinguished from one that is too cold or too hot: it counts
    /// as 155 degrees, so that the drive stops.
    pub fn celsius(&self, code: u16) -> f32 {
        let ratio = self.pull_up_ohm / self.ohm_at_25_c * f32::from(code) / (CODES - f32::from(code));
        let celsius = 1.0 / (1.0 / NOMINAL_K + logarithm(ratio) / self.beta_k) - ZERO_K;
        if (PLAUSIBLE_C.0..=PLAUSIBLE_C.1).contains(&celsius) { celsius } else { PLAUSIBLE_C.1 }
    }
}

/// The natural logarithm, within 6.2e-5. Below one micromath takes an approximate reciprocal, which is 8 % off, and 5 K: here it is divided.
fn logarithm(x: f32) -> f32 {
    if x < 1.0 { -F32(1.0 / x).ln().0 } else { F32(x).ln().0 }
}
