//! Units for public signatures: newtypes without arithmetic. Take the number out, compute, wrap it
//! again.

use serde::{Deserialize, Serialize};

/// Frequency, Hz.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
pub struct Hertz(pub f32);

/// Voltage, V; peak, unless a name states otherwise.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
pub struct Volts(pub f32);

/// Current, A; peak, unless a name states otherwise.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
pub struct Amperes(pub f32);

/// Phase or angle, turns: one turn is 360 degrees.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
pub struct Turns(pub f32);

impl Turns {
    /// Returns the angle in degrees.
    pub fn degrees(self) -> f32 {
        self.0 * 360.0
    }
}
