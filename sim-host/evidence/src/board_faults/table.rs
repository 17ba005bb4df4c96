//! The table of the campaign.

use report::{TableBlock, verdict};

use super::limits::Verdict;
use super::{KindRuns, Outcome};
use crate::campaign::{cells, columns, count, or_dash, tally};

/// Returns all tables.
pub fn tables(tried: &[KindRuns], seed: u64) -> Vec<TableBlock> {
    vec![results(tried, seed)]
}

fn micro(seconds: f64) -> String {
    format!("{:.2}", 1e6 * seconds)
}

fn results(tried: &[KindRuns], seed: u64) -> TableBlock {
    let caption = format!(
        "Seed {seed:#x}. Off: runs in which the amplifier was off or the drive muted; the worst is the longest time from the \
         fault until then. Reported: the reasons that the board reported afterwards over its serial line, with the number of \
         runs. On: runs in which the drive continued unchanged, within 5 Hz and 5 % of the tip velocity."
    );
    let header = columns("kind | fault | runs | off | worst, us | limit, us | reported | on | failed | ");
    TableBlock::new("board-faults", "Faults of the board", caption, &header, tried.iter().map(row).collect())
}

fn row(KindRuns { kind, runs }: &KindRuns) -> Vec<String> {
    let off: Vec<f64> = runs.iter().filter_map(|outcome| outcome.off_s).collect();
    let worst = or_dash(off.iter().copied().reduce(f64::max), micro);
    let limit = match kind.verdict {
        Verdict::Off(limit) => micro(limit.seconds()),
        Verdict::DrivesOn | Verdict::OffOrDrivesOn => "–".to_owned(),
    };
    let (on, failed) = (runs.len() - off.len(), count(runs, |outcome| outcome.failed.is_some()));
    cells![kind.name, kind.what, runs.len(), off.len(), worst, limit, reasons(runs), on, failed, verdict(failed == 0)]
}

fn reasons(outcomes: &[Outcome]) -> String {
    let off = outcomes.iter().filter(|outcome| outcome.off_s.is_some());
    let counts = tally(off.map(|outcome| outcome.reason.as_deref().unwrap_or("none")));
    counts.iter().map(|(reason, count)| format!("{reason} ({count})")).collect::<Vec<_>>().join(", ")
}
