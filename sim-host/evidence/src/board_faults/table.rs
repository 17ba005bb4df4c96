//! The campaign as tables.

use std::collections::BTreeMap;

use report::{TableBlock, verdict};

use super::limits::Verdict;
use super::{Outcome, Tried};

/// All tables.
pub fn tables(tried: &[Tried], seed: u64) -> Vec<TableBlock> {
    vec![results(tried, seed)]
}

fn micro(seconds: f64) -> String {
    format!("{:.2}", 1e6 * seconds)
}

fn results(tried: &[Tried], seed: u64) -> TableBlock {
    let caption = format!(
        "Seed {seed:#x}. Off: runs in which the amplifier was off or the drive muted; the worst is the longest time from the fault until then. Named: the reasons \
         that the board gave afterwards, over its serial line, with the number of runs. On: runs in which it drove on as before, within 5 Hz and 5 % of the tip velocity."
    );
    let header = ["kind", "fault", "runs", "off", "worst, us", "limit, us", "named", "on", "failed", ""];
    TableBlock::new("board-faults", "Faults of the board", caption, &header, tried.iter().map(row).collect())
}

fn row(tried: &Tried) -> Vec<String> {
    let outcomes = &tried.outcomes;
    let off: Vec<f64> = outcomes.iter().filter_map(|outcome| outcome.off_s).collect();
    let worst = off.iter().copied().reduce(f64::max);
    let limit = match tried.kind.verdict {
        Verdict::Off(limit) => micro(limit.seconds()),
        Verdict::DrivesOn | Verdict::OffOrDrivesOn => "–".to_owned(),
    };
    let failed = outcomes.iter().filter(|outcome| outcome.failed.is_some()).count();
    vec![
        tried.kind.name.to_owned(),
        tried.kind.what.to_owned(),
        outcomes.len().to_string(),
        off.len().to_string(),
        worst.map_or_else(|| "–".to_owned(), micro),
        limit,
        reasons(outcomes),
        (outcomes.len() - off.len()).to_string(),
        failed.to_string(),
        verdict(failed == 0).to_owned(),
    ]
}

fn reasons(outcomes: &[Outcome]) -> String {
    let mut counts = BTreeMap::new();
    for outcome in outcomes.iter().filter(|outcome| outcome.off_s.is_some()) {
        *counts.entry(outcome.reason.as_deref().unwrap_or("none")).or_insert(0) += 1;
    }
    let counts: Vec<String> = counts.into_iter().map(|(reason, count): (&str, u32)| format!("{reason} ({count})")).collect();
    counts.join(", ")
}
