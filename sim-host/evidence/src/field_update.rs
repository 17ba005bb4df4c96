//! Cuts the power while the flashed first stage and image update a board, on the model of the part.
//!
//! ```text
//! ELF files --> board with first stage, slot, store --> operations of its flash --> cut at one of them --> which image answers? --> table
//! ```
//!
//! The tests of `sonoglide-update` cut every operation, on simulated flash. Here a sample of them
//! is cut, with the thumb code.

pub mod boards;
mod table;

#[cfg(test)]
mod tests;

use board::Board;
use rayon::prelude::*;
use stm32g474::FlashOperation;

use self::boards::{FieldImages, Phase, prepared, version_after};
use crate::campaign;
use crate::campaign_error::CampaignError;
use crate::evidence::{Error, Evidence, Options};

/// Number of cuts of each phase.
const CUTS: usize = 100;
/// Number of cuts of each phase in the quick variant.
const QUICK_CUTS: usize = 4;
/// Number of boards that are kept before their cut at the same time.
const BATCH_BOARDS: usize = 16;
/// Number of cycles before an operation at which a board is kept.
const BEFORE_CYCLES: u64 = 2000;
/// Number of positions of a cut: at the beginning of an operation, within it, after it.
const POSITIONS: usize = 3;
/// Number of cycles from the beginning, or the end, of an operation to its cut.
const AFTER_CYCLES: u64 = 40;

/// The version that answered after a cut, or the reason of the failure.
pub type Outcome = Result<u16, String>;

/// Results of the cuts of a phase.
#[derive(Clone, Debug)]
pub struct PhaseRuns {
    /// The phase.
    pub phase: Phase,
    /// Number of flash operations in the phase.
    pub operations: usize,
    /// Result of each cut.
    pub outcomes: Vec<Outcome>,
}

/// Runs the campaign.
pub fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let cuts = if options.quick { QUICK_CUTS } else { CUTS };
    let tried = campaign(&FieldImages::built()?, &Phase::ALL, cuts, &mut |next| (options.progress)(next))?;
    let tables = vec![table::table(&tried)];
    let missed = tried.iter().flat_map(|tried| {
        let failed = tried.outcomes.iter().filter_map(|outcome| outcome.as_ref().err());
        failed.map(|failed| format!("{}: {failed}", tried.phase.name()))
    });
    let subtitle = "Simulated: the part that runs first stage and image";
    Ok(campaign::evidence("Power cuts while a board is updated", subtitle, tables, Vec::new(), missed.collect()))
}

/// Cuts each phase `cuts` times, at operations spread over it: at their beginning, within them and
/// after them in turn.
pub fn campaign(
    images: &FieldImages,
    phases: &[Phase],
    cuts: usize,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<PhaseRuns>, CampaignError> {
    let tried = phases.iter().map(|&phase| {
        progress(phase.name());
        let (board, operations) = prepared(images, phase)?;
        // Each operation is cut at most once in each position.
        let cuts = cuts.min(POSITIONS * operations.len());
        Ok(PhaseRuns { phase, operations: operations.len(), outcomes: outcomes(board, phase, &operations, cuts)? })
    });
    tried.collect()
}

fn outcomes(mut board: Board, phase: Phase, operations: &[FlashOperation], cuts: usize) -> Result<Vec<Outcome>, CampaignError> {
    let mut outcomes = Vec::with_capacity(cuts);
    let numbers: Vec<usize> = (0..cuts).collect();
    for batch in numbers.chunks(BATCH_BOARDS) {
        let mut standing = Vec::with_capacity(batch.len());
        for &n in batch {
            let operation = operations[n * (operations.len() - 1) / (cuts - 1).max(1)];
            let FlashOperation { first, last, .. } = operation;
            let at = [first + AFTER_CYCLES, (first + last) / 2, last + AFTER_CYCLES][n % POSITIONS];
            if board.machine().cycle() < first.saturating_sub(BEFORE_CYCLES) {
                board.machine_mut().run_until(first.saturating_sub(BEFORE_CYCLES))?;
            }
            standing.push((board.clone(), at.max(board.machine().cycle() + 1)));
        }
        outcomes.par_extend(standing.into_par_iter().map(|(board, at)| version_after(board, at, phase)));
    }
    Ok(outcomes)
}
