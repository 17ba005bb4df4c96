//! Temperature of the heat sink, from a thermistor.
//!
//! ```text
//! 1 / T = 1 / 298.15 + ln(R / R25) / B,    R = R_up code / (codes - code)      (T in kelvin)
//! ```
//!
//! The equation of a thermistor by its coefficient B, IEC 60539-1. The thermistor is fed by the
//! converter's own supply, which cancels. Its logarithm is micromath's, 6e-5 off above one, which
//! is 0.003 K at most from -40 to 150 degrees Celsius: a thermistor of 1 % is 0.2 K off by itself.

use firmware::seam::config::HeatSink;
use micromath::F32;

/// Temperatures that a thermistor of a heat sink can show, degrees Celsius.
const PLAUSIBLE_C: (f32, f32) = (-55.0, 155.0);
/// 0 and 25 degrees Celsius, K.
const ZERO_K: f32 = 273.15;
const NOMINAL_K: f32 = ZERO_K + 25.0;

/// A thermistor of negative coefficient from its input to ground, below a resistor to the
/// converter's supply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermistor {
    /// Its resistance at 25 degrees Celsius, ohm.
    pub ohm_at_25_c: f32,
    /// Its coefficient B, K.
    pub beta_k: f32,
    /// The resistor to the supply, ohm.
    pub pull_up_ohm: f32,
    /// Codes of the converter from zero to its supply: 4096 for 12 bits.
    pub codes: f32,
}

impl Thermistor {
    /// The thermistor of the settings, at a converter of so many codes; `None` where there is none.
    #[inline]
    pub fn of(heat_sink: &HeatSink, codes: f32) -> Option<Self> {
        let HeatSink { ohm_at_25_c, beta_k, pull_up_ohm } = *heat_sink;
        ohm_at_25_c.map(|ohm_at_25_c| Thermistor { ohm_at_25_c, beta_k, pull_up_ohm, codes })
    }

    /// Degrees Celsius of a code. A thermistor that is open or short cannot be distinguished from
    /// one that is too cold or too hot: it counts as 155 degrees, so that the drive stops.
    #[inline]
    pub fn celsius(&self, code: u16) -> f32 {
        let ratio = self.pull_up_ohm / self.ohm_at_25_c * f32::from(code) / (self.codes - f32::from(code));
        let celsius = 1.0 / (1.0 / NOMINAL_K + logarithm(ratio) / self.beta_k) - ZERO_K;
        if (PLAUSIBLE_C.0..=PLAUSIBLE_C.1).contains(&celsius) { celsius } else { PLAUSIBLE_C.1 }
    }
}

/// The natural logarithm, within 6.2e-5. Below one micromath takes an approximate reciprocal, which
/// is 8 % off, and 5 K: here it is divided.
fn logarithm(x: f32) -> f32 {
    if x < 1.0 { -F32(1.0 / x).ln().0 } else { F32(x).ln().0 }
}
