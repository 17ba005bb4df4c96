//! A campaign of faults against the flashed image: each kind many times, at another time, in another bit, against the protection that `docs/board.md` states.
//!
//! ```text
//! ELF --> board (part, plant of the dummy load) that drives --clone--> fault at a random time --> off in time? reason named? --> tables
//! ```
//!
//! The runs are those of the model of the part, not of silicon: what the model does not have, no run can show.

pub mod inject;
pub mod kinds;
pub mod limits;
pub mod run;
pub mod snapshot;
pub mod table;

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use self::kinds::{KINDS, Kind};
use self::run::{Outcome, run};
use crate::campaign_error::CampaignError;
use crate::evidence::{Error, Evidence, Options};
use report::Report;

/// The seed of the campaign.
pub const SEED: u64 = 0x5046_4155_4c54;
/// Runs of each kind.
const RUNS: u32 = 100;
const QUICK: u32 = 4;

/// The runs of a kind.
#[derive(Clone, Debug)]
pub struct Tried {
    /// The kind.
    pub kind: &'static Kind,
    /// What came of each run, in order.
    pub outcomes: Vec<Outcome>,
}

/// Runs the campaign.
pub fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let elf = std::fs::read(pil::board_image()?).map_err(CampaignError::Io)?;
    let runs = if options.quick { QUICK } else { RUNS };
    let tried = campaign(&elf, KINDS, runs, SEED, &mut |next| (options.progress)(next))?;
    let tables = table::tables(&tried, SEED);
    let missed = tried.iter().flat_map(|tried| {
        let runs = tried.outcomes.iter().enumerate();
        runs.filter_map(|(run, outcome)| {
            outcome.failed.as_ref().map(|failed| format!("{}, run {run} ({}): {failed}", tried.kind.name, outcome.drawn))
        })
    });
    Ok(Evidence {
        missed: missed.collect(),
        report: Report {
            title: "Faults of the board: the flashed image on the model of its part".into(),
            subtitle: "Simulated: the part, its wires and the dummy load".into(),
            tables: tables.clone(),
            ..Report::default()
        },
        docs: tables,
        ..Evidence::default()
    })
}

/// Runs each of these kinds so often, from one board that drives.
pub fn campaign(
    elf: &[u8],
    kinds: &'static [Kind],
    runs: u32,
    seed: u64,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<Tried>, CampaignError> {
    let snapshot = snapshot::driving(elf)?;
    let tried = kinds.iter().map(|kind| {
        progress(kind.name);
        Tried { kind, outcomes: (0..runs).into_par_iter().map(|number| run(&snapshot, kind, seed, number)).collect() }
    });
    Ok(tried.collect())
}
