//! Speed against error: all methods on one standard case, the claims about them, and the hard
//! cases.
//!
//! ```text
//! case --> reference (Taylor 28/32, checked by an independent method)
//!   |          |
//!   +--> work: errors of every method at every step count, interleaved times, instructions
//!                  |
//!                  +--> claims (ratios at equal error)      hard: cases with their invariants
//! ```

pub mod claims;
pub mod folder;
pub mod hard;
pub mod instructions;
pub mod interpolate;
pub mod method;
pub mod plots;
pub mod reference;
pub mod rk4_tabulated;
pub mod sample;
pub mod single;
pub mod study;
pub mod table;
pub mod work;

use crate::evidence::{Error, Evidence, Options};
use study::measure;

/// Measures all methods and builds the page and the files.
pub fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let study = measure(options)?;
    let printed = vec![
        table::reference(&study.reference),
        table::work(&study),
        table::hard_in_short(&study.hard),
        table::claims(&study.claims),
    ];
    let summary = folder::summary(&study);
    let failed = study.hard.iter().filter(|(_, found)| !found.as_ref().is_ok_and(hard::HardResult::holds));
    Ok(Evidence {
        report: folder::page(&study),
        printed: Some(printed),
        missed: failed.map(|(case, _)| case.name.to_owned()).collect(),
        files: vec![("summary.json", format!("{summary:#}\n")), ("work.csv", folder::work(&study)?)],
        summary,
        ..Evidence::default()
    })
}
