//! Temperature of the heat sink, measured by a thermistor.
//!
//! ```text
//! 1 / T = 1 / 298.15 + ln(R / R25) / B,    R = R_up code / (codes - code)      (T in kelvin)
//! ```
//!
//! This is the equation of a thermistor with coefficient B, IEC 60539-1. The converter's own supply
//! feeds the thermistor, so its voltage cancels. The logarithm is that of micromath, with an error
//! of 6e-5 above one: at most 0.003 K from -40 to 150 degrees Celsius. A thermistor of 1 % has an
//! error of 0.2 K.

use firmware::seam::config::HeatSink;
use micromath::F32;

/// Lowest plausible temperature of a heat sink, degrees Celsius.
const MIN_PLAUSIBLE_C: f32 = -55.0;
/// Highest plausible temperature of a heat sink, degrees Celsius.
const MAX_PLAUSIBLE_C: f32 = 155.0;
/// Temperature of 0 degrees Celsius, K.
const ZERO_K: f32 = 273.15;
/// Nominal temperature of a thermistor, 25 degrees Celsius, K.
const NOMINAL_K: f32 = ZERO_K + 25.0;

/// NTC thermistor from the converter's input to ground, with a pull-up resistor to the converter's
/// supply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermistor {
    /// Resistance at 25 degrees Celsius, ohm.
    pub ohm_at_25_c: f32,
    /// Coefficient B, K.
    pub beta_k: f32,
    /// Pull-up resistor, ohm.
    pub pull_up_ohm: f32,
    /// Number of codes of the converter from zero to its supply: 4096 for 12 bits.
    pub codes: f32,
}

impl Thermistor {
    /// Creates the thermistor of the settings, for a converter with this number of codes. Returns
    /// `None` if there is no thermistor.
    #[inline]
    pub fn from_settings(heat_sink: &HeatSink, codes: f32) -> Option<Self> {
        let HeatSink { ohm_at_25_c, beta_k, pull_up_ohm } = *heat_sink;
        ohm_at_25_c.map(|ohm_at_25_c| Thermistor { ohm_at_25_c, beta_k, pull_up_ohm, codes })
    }

    /// Returns the temperature of a code, degrees Celsius.
    ///
    /// An open or shorted thermistor cannot be distinguished from one that is too cold or too hot.
    /// It counts as 155 degrees, so that the drive stops.
    #[inline]
    pub fn celsius(&self, code: u16) -> f32 {
        let ratio = self.pull_up_ohm / self.ohm_at_25_c * f32::from(code) / (self.codes - f32::from(code));
        let celsius = 1.0 / (1.0 / NOMINAL_K + logarithm(ratio) / self.beta_k) - ZERO_K;
        if (MIN_PLAUSIBLE_C..=MAX_PLAUSIBLE_C).contains(&celsius) { celsius } else { MAX_PLAUSIBLE_C }
    }
}

/// Returns the natural logarithm with an error of at most 6.2e-5.
///
/// Below one, micromath uses an approximate reciprocal with an error of 8 % (5 K); this function
/// divides instead.
fn logarithm(x: f32) -> f32 {
    if x < 1.0 { -F32(1.0 / x).ln().0 } else { F32(x).ln().0 }
}
