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
mod tests;

use crate::evidence::{Error, Evidence, Options};
use report::Report;

use budget::Judged;
use host::{Generator, Quality};
use target::Counted;

/// A way to make the drive's sine: what it costs and how good it is.
pub struct Row {
    /// Generator of the sine.
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

/// The measurement with its page.
pub fn evidence(_: &mut Options) -> Result<Evidence, Error> {
    let measurement = measure()?;
    let tables = table::tables(&measurement);
    let over = measurement.judged.iter().filter(|judged| !judged.holds());
    Ok(Evidence {
        report: Report {
            title: "Instructions: speed against error on the target".into(),
            subtitle: "Counted by an emulated Cortex-M4F; instructions, not cycles".into(),
            tables: tables.clone(),
            ..Report::default()
        },
        missed: over.map(|judged| judged.bound.name.clone()).collect(),
        docs: tables,
        ..Evidence::default()
    })
}
