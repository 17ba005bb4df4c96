//! Cost and accuracy on the target: instructions a sample, counted in QEMU, with errors and spectra
//! computed on the host.
//!
//! ```text
//! image `counts` -----> target (ticks of every kernel) --+--> budget (largest cost of each)
//!                                                        |
//! controller's sine --> host (error, spectrum) ----------+--> table
//! ```
//!
//! Instructions, not cycles: on a Cortex-M4 most instructions take one cycle, a taken branch two to
//! four, a load two, and flash has wait states.

pub mod budget;
pub mod host;
pub mod table;
pub mod target;

#[cfg(test)]
mod tests;

use crate::campaign;
use crate::evidence::{Error, Evidence, Options};

use budget::Judged;
use host::{Generator, Quality};
use target::Counted;

/// A generator of the drive's sine with its cost and quality.
pub struct Row {
    /// Generator of the sine.
    pub generator: Generator,
    /// Instructions for one sine with its cosine.
    pub instructions: f64,
    /// Errors and spectrum of the sine.
    pub quality: Quality,
}

/// Instruction counts and the numbers computed from them.
pub struct Measurement {
    /// Every kernel on the target.
    pub counted: Vec<Counted>,
    /// Counts of the sine generators, with their quality.
    pub generators: Vec<Row>,
    /// The budget, each line with its count.
    pub judged: Vec<Judged>,
}

/// Builds and runs the image, and computes the rest.
pub fn measure() -> Result<Measurement, Error> {
    let counted = target::count()?;
    let row = |generator: Generator| {
        let instructions = target::find(&counted, "generator", generator.name)?.per_sample();
        Ok(Row { generator, instructions, quality: host::quality(&generator) })
    };
    let generators = host::GENERATORS.into_iter().map(row).collect::<Result<Vec<_>, Error>>()?;
    let judged = budget::judge(&counted, &generators)?;
    Ok(Measurement { counted, generators, judged })
}

/// Measures, and returns the evidence.
pub fn evidence(_: &mut Options) -> Result<Evidence, Error> {
    let measurement = measure()?;
    let tables = table::tables(&measurement);
    let over = measurement.judged.iter().filter(|judged| !judged.holds());
    let missed = over.map(|judged| judged.bound.name.clone()).collect();
    let subtitle = "Counted by an emulated Cortex-M4F; instructions, not cycles";
    Ok(campaign::evidence("Instructions: cost and accuracy on the target", subtitle, tables, Vec::new(), missed))
}
