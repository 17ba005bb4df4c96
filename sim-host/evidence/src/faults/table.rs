//! The results as tables and rows of CSV, and the list of missed targets.

use report::{TableBlock, verdict};

use super::FaultRun;
use super::kinds::{Kind, PARTS, Part};
use super::place::PLACES;
use super::verdict::Verdict;
use crate::campaign::{self, cells, columns, count, digits, or_dash, tally, worst};
use crate::evidence::Error;

/// Runs of a kind of failure.
type KindRuns = campaign::KindRuns<&'static Kind, FaultRun>;

/// Longest time that a run may be dangerous if no longer time is promised, ms.
const DANGEROUS_MS: f64 = 5.0;
/// Longest time that a start may be dangerous, ms: until the lock is given up.
const EARLY_MS: f64 = 20.0;

/// Faults in which a start may end: those of the checks that it must pass.
const START_CHECKS: core::ops::RangeInclusive<u8> = 20..=34;

/// Returns the reason why a run is not as promised.
fn violation(kind: &Kind, run: &FaultRun) -> Option<&'static str> {
    let (verdict, early) = (&run.verdict, run.place.is_during_start());
    // A failure during the start is calibrated away, or detected at the end of its stage.
    let in_time = |most: f64| verdict.off_ms.map_or(early && !verdict.dangerous_at_end, |off| off <= most || early);
    let named = kind.named.contains(&verdict.reported_code) || early && START_CHECKS.contains(&verdict.reported_code);
    match () {
        () if verdict.is_undetected() => Some("dangerous, but not reported"),
        () if verdict.dangerous_ms > kind.off_ms.unwrap_or(0.0).max(if early { EARLY_MS } else { DANGEROUS_MS }) => {
            Some("dangerous for too long")
        }
        () if kind.named.is_empty() && verdict.reported_code != 0 && verdict.reported_code < 96 => {
            Some("harmless, but reported as a fault")
        }
        () if kind.off_ms.is_some_and(|most| !in_time(most)) => Some("not off in time"),
        () if verdict.reported_code >= 10 && verdict.reported_code < 96 && !named => Some("reported as a wrong fault"),
        () => None,
    }
}

/// Lists the missed targets: the first run of each kind, and of those without a failure, that is
/// not as promised.
pub(super) fn missed(tried: &[KindRuns], calm: &[FaultRun]) -> Vec<String> {
    let of_kind = |KindRuns { kind, runs }: &KindRuns| {
        let count = count(runs, |run| violation(kind, run).is_some());
        let (run, why) = runs.iter().find_map(|run| Some((run, violation(kind, run)?)))?;
        let FaultRun { place, seed, verdict } = run;
        let (all, code) = (runs.len(), verdict.reported_code);
        Some(format!("{}: {count} of {all} runs; the first: {}, seed {seed}: {why} ({code})", kind.name, place.name))
    };
    let mut missed: Vec<String> = tried.iter().filter_map(of_kind).collect();
    let trips: Vec<_> = calm.iter().filter(|run| run.verdict.reported_code != 0 || run.verdict.dangerous_at_end).collect();
    if let Some(FaultRun { place, seed, .. }) = trips.first() {
        let (count, all) = (trips.len(), calm.len());
        missed.push(format!("without a failure: {count} of {all} runs; the first: {}, seed {seed}", place.name));
    }
    missed
}

/// Returns all tables.
pub(super) fn tables(tried: &[KindRuns], calm: &[FaultRun]) -> Vec<TableBlock> {
    vec![by_part(tried), matrix(tried), without(calm)]
}

/// Returns a summary of the matrix, by the part that fails.
fn by_part(tried: &[KindRuns]) -> TableBlock {
    let mut rest = tried;
    let row = |part: &Part| {
        let (here, others) = rest.split_at(part.kinds.len());
        rest = others;
        let all: Vec<&Verdict> = here.iter().flat_map(|of| &of.runs).map(|run| &run.verdict).collect();
        let (off, on): (Vec<&Verdict>, Vec<&Verdict>) = all.iter().partition(|verdict| verdict.off_ms.is_some());
        let on = |is: fn(&Verdict) -> bool| count(on.iter().copied(), is);
        cells![
            part.name,
            here.len(),
            all.len(),
            off.len(),
            count_codes(all.iter().map(|verdict| verdict.reported_code)),
            digits(worst(off.iter().filter_map(|verdict| verdict.off_ms))),
            digits(worst(off.iter().map(|verdict| verdict.energy_j))),
            on(|verdict| verdict.reported_code != 0),
            on(|verdict| verdict.reported_code == 0 && !verdict.dangerous_at_end),
            on(Verdict::is_undetected),
            digits(worst(all.iter().map(|verdict| verdict.dangerous_ms))),
        ]
    };
    let header = columns(
        "part | kinds | runs | off | by fault or limit | off within [ms] | energy until then [J] | limited | harmless | \
         undetected | dangerous [ms]",
    );
    let caption = "Off: ended by a fault; the longest time of drive until then, and the largest energy into the motional branch. \
                   Limited, harmless, undetected: not ended, as below. Dangerous: the longest time above 1.2 times the voltage \
                   limit, or more than half a bandwidth off resonance, before it was off.";
    TableBlock::new("parts", "Failures by the part that fails", caption, &header, PARTS.iter().map(row).collect())
}

fn matrix(tried: &[KindRuns]) -> TableBlock {
    let row = |KindRuns { kind, runs }: &KindRuns| {
        let off: Vec<f64> = runs.iter().filter_map(|run| run.verdict.off_ms).collect();
        let silent = |dangerous| count(runs, |run| run.verdict.reported_code == 0 && run.verdict.dangerous_at_end == dangerous);
        cells![
            kind.name,
            kind.what,
            runs.len(),
            off.len(),
            or_dash((!off.is_empty()).then(|| worst(off.iter().copied())), digits),
            or_dash(kind.off_ms, digits),
            count(runs, |run| run.verdict.reported_code >= 96),
            silent(false),
            silent(true),
            digits(worst(runs.iter().map(|run| run.verdict.dangerous_ms))),
            digits(worst(runs.iter().map(|run| run.verdict.energy_j))),
            count_codes(runs.iter().map(|run| run.verdict.reported_code)),
            verdict(runs.iter().all(|run| violation(kind, run).is_none())),
        ]
    };
    let header = columns(
        "kind | failure | runs | off | worst off [ms] | promised [ms] | limited | harmless | undetected | dangerous [ms] | \
         energy [J] | reported | ",
    );
    let caption = "Off: ended by a fault, with the longest time of drive after the failure. Limited: the drive continues, and a \
                   limit is reported. Harmless: the drive continues unchanged, and nothing is reported. Undetected: it \
                   continues, more than 1.2 times above the voltage limit or more than half a bandwidth off resonance, and \
                   nothing is reported. Dangerous: the longest time in such a state. Energy: the largest into the motional \
                   branch after the failure. Reported: faults and limits, with their number.";
    TableBlock::new("matrix", "Failures while the drive runs", caption, &header, tried.iter().map(row).collect())
}

fn count_codes(codes: impl Iterator<Item = u8>) -> String {
    let mut counts: Vec<(u8, usize)> = tally(codes.filter(|&code| code != 0)).into_iter().collect();
    counts.sort_by_key(|&(code, count)| (usize::MAX - count, code));
    let each: Vec<String> = counts.iter().map(|(code, count)| format!("{code} ({count})")).collect();
    each.join(", ")
}

fn without(calm: &[FaultRun]) -> TableBlock {
    let row = |place: &super::Place| {
        let runs: Vec<&Verdict> = calm.iter().filter(|run| run.place.name == place.name).map(|run| &run.verdict).collect();
        let of = |is: fn(&Verdict) -> bool| count(runs.iter().copied(), is);
        let dangerous_ms = digits(worst(runs.iter().map(|verdict| verdict.dangerous_ms)));
        let (reported, dangerous) = (of(|verdict| verdict.reported_code != 0), of(|verdict| verdict.dangerous_at_end));
        cells![place.name, runs.len(), reported, dangerous_ms, dangerous]
    };
    let header = columns("place | runs | reported | dangerous [ms] | dangerous at the end");
    let caption = "Reported: a fault has ended the run, or a limit holds in most of its last 10 ms. Dangerous: the longest time \
                   in such a state, and the number of runs that end in it. While it searches its lock, the observer drives off \
                   resonance on purpose.";
    TableBlock::new("without", "The same without a failure", caption, &header, PLACES.iter().map(row).collect())
}

/// Returns one row of CSV per run.
pub(super) fn csv(tried: &[KindRuns], calm: &[FaultRun]) -> Result<String, Error> {
    let of_kinds = tried.iter().flat_map(|of| of.runs.iter().map(|run| (of.kind.name, run)));
    let rows = of_kinds.chain(calm.iter().map(|run| ("none", run))).map(|(kind, FaultRun { place, seed, verdict })| {
        let off_ms = verdict.off_ms.map_or_else(String::new, |off| format!("{off:.4}"));
        let [energy_j, dangerous_ms] = [format!("{:.6}", verdict.energy_j), format!("{:.4}", verdict.dangerous_ms)];
        cells![kind, place.name, seed, verdict.reported_code, off_ms, energy_j, dangerous_ms, verdict.dangerous_at_end]
    });
    campaign::csv("kind,place,seed,said,off_ms,energy_j,dangerous_ms,dangerous_in_the_end", rows)
}
