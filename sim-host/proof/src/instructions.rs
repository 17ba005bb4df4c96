//! Speed against error on the target: instructions a sample, counted in QEMU, beside errors and spectra, computed here.
//!
//! ```text
//! image `counts` -----> target (ticks of every kernel) --+--> budget (what each may cost)
//!                                                        |
//! controller's sine --> host (error, spectrum) ----------+--> table
//! ```
//!
//! Instructions, not cycles: on a Cortex-M4 most take one, a taken branch two to four, a load two, and flash has wait states.

pub mod budget;
pub mod host;
pub mod table;
pub mod target;

#[cfg(test)]
pub(crate) mod tests;

use pil::PilError;

use budget::Judged;
use host::{Generator, Quality};
use target::Counted;

/// A way to make the drive's sine: what it costs and how good it is.
pub struct Row {
    /// Which.
    pub generator: Generator,
    /// Instructions for one sine with its cosine.
    pub instructions: f64,
    /// How good it is.
    pub quality: Quality,
}

/// Everything that was counted and computed.
pub struct Measurement {
    /// Every kernel on the target.
    pub counted: Vec<Counted>,
    /// The generators among them.
    pub generators: Vec<Row>,
    /// The budget, each line with what was counted.
    pub judged: Vec<Judged>,
}

impl Measurement {
    /// Whether everything is within its budget.
    pub fn holds(&self) -> bool {
        self.judged.iter().all(Judged::holds)
    }
}

/// Why there is no measurement.
#[derive(Debug, thiserror::Error)]
pub enum Trouble {
    /// The image could not be built or run.
    #[error(transparent)]
    Pil(#[from] PilError),
    /// QEMU did not run the image to its end.
    #[error("the image failed with {0}")]
    Failed(String),
    /// What the image printed is not what it should be.
    #[error("the image printed something else than counts: {0}")]
    Printed(String),
}

/// Builds and runs the image, and computes the rest.
pub fn conduct() -> Result<Measurement, Trouble> {
    let counted = target::count()?;
    let row = |generator: Generator| {
        let instructions = target::find(&counted, "generator", generator.name)?.per_sample();
        Ok(Row { generator, instructions, quality: host::quality(&generator) })
    };
    let generators = host::GENERATORS.into_iter().map(row).collect::<Result<Vec<_>, Trouble>>()?;
    let judged = budget::judge(&counted, &generators)?;
    Ok(Measurement { counted, generators, judged })
}
