//! Units for public signatures. Tuple newtypes without algebra: take the number out, compute, wrap it again.

use serde::{Deserialize, Serialize};

/// A frequency in hertz.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
pub struct Hertz(pub f32);

/// Voltage in volts; peak, unless a name says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
pub struct Volts(pub f32);

/// Current in amperes; peak, unless a name says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
pub struct Amperes(pub f32);

/// Phase or angle in turns: one turn is 360 degrees.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
pub struct Turns(pub f32);

impl Turns {
    /// The angle in degrees.
    pub fn degrees(self) -> f32 {
        self.0 * 360.0
    }
}
