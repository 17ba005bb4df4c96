//! Measured files: the circuit of an admittance as a scene.

use import::admittance::{fit, measured::Measured, options::Options};
use serde_json::{Value, json};

use crate::outcome::table;
use crate::request::{Request, stem};

impl Request {
    /// Fits a circuit to the text, a measured admittance. Returns its scene, null if the circuit
    /// does not describe the data, with the numbers and the warnings of the fit.
    ///
    /// # Errors
    /// The message of `sim-host import admittance`.
    pub fn fit(&self) -> Result<Value, String> {
        let measured = Measured::parse(&self.name, self.text.as_deref().unwrap_or_default().as_bytes(), &Options::default());
        let found = measured.and_then(|measured| fit(stem(&self.name), measured, None)).map_err(|error| {
            format!("error: {error}\n`sim-host import admittance {}` has options for columns and units.", self.name)
        })?;
        let scene = found.scene(&self.name).filter(|_| !found.is_doubtful());
        Ok(json!({ "scene": scene, "tables": found.tables().iter().map(table).collect::<Vec<_>>(), "warnings": found.warnings }))
    }
}
