//! Power cuts while a board is updated: by the first stage and the image as they are flashed, on the model of the part.
//!
//! ```text
//! ELF files --> board with first stage, slot, store --> operations of its flash --> cut at one of them --> who answers? --> table
//! ```
//!
//! Every operation is cut on simulated flash, by the tests of `sonoglide-update`; here it is a sample of them, by the thumb code.

pub mod boards;
mod table;

#[cfg(test)]
mod tests;

use board::Board;
use rayon::prelude::*;
use report::Report;
use stm32g474::FlashOperation;

use self::boards::{FieldImages, Phase, prepared, version_after};
use crate::campaign_error::CampaignError;
use crate::evidence::{Error, Evidence, Options};

/// Cuts of each phase.
const CUTS: usize = 100;
const QUICK: usize = 4;
/// Boards that stand before their cut at once.
const BATCH: usize = 16;
/// Cycles before an operation at which a board is left standing.
const BEFORE: u64 = 2000;
/// Places of a cut: at the beginning of an operation, within it, after it.
const POSITIONS: usize = 3;
/// Cycles after the beginning, or the end, of an operation.
const AFTER: u64 = 40;

/// The version that answered after a cut, or what was wrong.
pub type Outcome = Result<u16, String>;

/// What the cuts of a phase have come to.
#[derive(Clone, Debug)]
pub struct Tried {
    /// The phase.
    pub phase: Phase,
    /// Operations of the flash in it.
    pub operations: usize,
    /// What each cut has come to.
    pub outcomes: Vec<Outcome>,
}

/// Runs the campaign.
pub fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let cuts = if options.quick { QUICK } else { CUTS };
    let tried = campaign(&FieldImages::built()?, &Phase::ALL, cuts, &mut |next| (options.progress)(next))?;
    let tables = vec![table::table(&tried)];
    let missed = tried.iter().flat_map(|tried| {
        let failed = tried.outcomes.iter().filter_map(|outcome| outcome.as_ref().err());
        failed.map(|failed| format!("{}: {failed}", tried.phase.name()))
    });
    Ok(Evidence {
        missed: missed.collect(),
        report: Report {
            title: "Power cuts while a board is updated".into(),
            subtitle: "Simulated: the part that runs first stage and image".into(),
            tables: tables.clone(),
            ..Report::default()
        },
        docs: tables,
        ..Evidence::default()
    })
}

/// Cuts each phase so often, at operations spread over it: at their beginning, within them, or after them in turns.
pub fn campaign(
    images: &FieldImages,
    phases: &[Phase],
    cuts: usize,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<Tried>, CampaignError> {
    let tried = phases.iter().map(|&phase| {
        progress(phase.name());
        let (board, operations) = prepared(images, phase)?;
        // Each operation at most at its beginning, within it, and after it.
        let cuts = cuts.min(POSITIONS * operations.len());
        Ok(Tried { phase, operations: operations.len(), outcomes: outcomes(board, phase, &operations, cuts)? })
    });
    tried.collect()
}

fn outcomes(mut board: Board, phase: Phase, operations: &[FlashOperation], cuts: usize) -> Result<Vec<Outcome>, CampaignError> {
    let mut outcomes = Vec::with_capacity(cuts);
    let numbers: Vec<usize> = (0..cuts).collect();
    for batch in numbers.chunks(BATCH) {
        let mut standing = Vec::with_capacity(batch.len());
        for &n in batch {
            let operation = operations[n * (operations.len() - 1) / (cuts - 1).max(1)];
            let FlashOperation { first, last, .. } = operation;
            let at = [first + AFTER, (first + last) / 2, last + AFTER][n % POSITIONS];
            if board.machine().cycle() < first.saturating_sub(BEFORE) {
                board.machine_mut().run_until(first.saturating_sub(BEFORE))?;
            }
            standing.push((board.clone(), at.max(board.machine().cycle() + 1)));
        }
        outcomes.par_extend(standing.into_par_iter().map(|(board, at)| version_after(board, at, phase)));
    }
    Ok(outcomes)
}
