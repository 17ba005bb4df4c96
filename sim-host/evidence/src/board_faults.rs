//! Injects faults while the flashed image drives: each kind many times, at random times and bits,
//! against the protection that `docs/board.md` states.
//!
//! ```text
//! ELF --> board (part, plant of the dummy load) that drives --clone--> fault at a random time --> off in time? reason reported? --> tables
//! ```
//!
//! The runs are on a model of the part, not on silicon; they cannot show anything that the model
//! lacks.

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
use crate::campaign;
use crate::campaign_error::CampaignError;
use crate::evidence::{Error, Evidence, Options};

/// Seed of the campaign.
pub const SEED: u64 = 0x5046_4155_4c54;
/// Number of runs of each kind.
const RUNS: u32 = 100;
/// Number of runs of each kind in a quick campaign.
const QUICK_RUNS: u32 = 4;

/// The runs of a kind.
pub type KindRuns = campaign::KindRuns<&'static Kind, Outcome>;

/// Runs the campaign.
pub fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let elf = std::fs::read(pil::board_image()?).map_err(CampaignError::Io)?;
    let runs = if options.quick { QUICK_RUNS } else { RUNS };
    let tried = campaign(&elf, KINDS, runs, SEED, &mut |next| (options.progress)(next))?;
    let tables = table::tables(&tried, SEED);
    let missed = tried.iter().flat_map(|KindRuns { kind, runs }| {
        runs.iter().enumerate().filter_map(|(run, outcome)| {
            outcome.failed.as_ref().map(|failed| format!("{}, run {run} ({}): {failed}", kind.name, outcome.drawn))
        })
    });
    let title = "Faults of the board: the flashed image on the model of its part";
    let subtitle = "Simulated: the part, its wires and the dummy load";
    Ok(campaign::evidence(title, subtitle, tables, Vec::new(), missed.collect()))
}

/// Runs each kind `runs` times, each from a copy of one board that drives.
pub fn campaign(
    elf: &[u8],
    kinds: &'static [Kind],
    runs: u32,
    seed: u64,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<KindRuns>, CampaignError> {
    let snapshot = snapshot::driving(elf)?;
    let tried = kinds.iter().map(|kind| {
        progress(kind.name);
        KindRuns { kind, runs: (0..runs).into_par_iter().map(|number| run(&snapshot, kind, seed, number)).collect() }
    });
    Ok(tried.collect())
}
