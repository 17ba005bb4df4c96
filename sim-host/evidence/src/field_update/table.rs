//! The campaign as a table.

use report::{TableBlock, verdict};

use super::Tried;

/// The table.
pub fn table(tried: &[Tried]) -> TableBlock {
    let caption = "Operations: erases of a page and words of eight bytes that are written in the phase. Cut: operations in which the power was cut, spread over the phase, at their \
         beginning, within them or after them in turns. Old, new: the image that answered its host afterwards, with the amplifier off all the time.";
    let header = ["while", "operations", "cut", "old image", "new image", "failed", ""];
    TableBlock::new("update-cuts", "Power cuts during an update", caption.to_owned(), &header, tried.iter().map(row).collect())
}

fn row(tried: &Tried) -> Vec<String> {
    let count = |version: u16| tried.outcomes.iter().filter(|outcome| **outcome == Ok(version)).count();
    let failed = tried.outcomes.iter().filter(|outcome| outcome.is_err()).count();
    let numbers = [tried.operations, tried.outcomes.len(), count(1), count(2), failed].map(|number| number.to_string());
    [tried.phase.name().to_owned()].into_iter().chain(numbers).chain([verdict(failed == 0).to_owned()]).collect()
}
