//! The table of the campaign.

use report::{TableBlock, verdict};

use super::PhaseRuns;
use crate::campaign::cells;

/// Returns the table.
pub fn table(tried: &[PhaseRuns]) -> TableBlock {
    let caption = "Operations: erased pages and written words of eight bytes in the phase. Cut: operations at which the power \
                   was cut, spread over the phase, at their beginning, within them or after them in turn. Old, new: the image \
                   that answered its host afterwards, with the amplifier off all the time.";
    let header = ["phase", "operations", "cut", "old image", "new image", "failed", ""];
    TableBlock::new("update-cuts", "Power cuts during an update", caption.to_owned(), &header, tried.iter().map(row).collect())
}

fn row(tried: &PhaseRuns) -> Vec<String> {
    let count = |version: u16| tried.outcomes.iter().filter(|outcome| **outcome == Ok(version)).count();
    let failed = tried.outcomes.iter().filter(|outcome| outcome.is_err()).count();
    let (phase, cut) = (tried.phase.name(), tried.outcomes.len());
    cells![phase, tried.operations, cut, count(1), count(2), failed, verdict(failed == 0)]
}
