//! The matrix as tables, as rows of a file, and what is missed.

use std::collections::BTreeMap;

use report::{TableBlock, verdict};
use sim::numbers::number;

use super::Tried;
use super::kinds::{self, Kind, PARTS, Part};
use super::place::PLACES;
use super::verdict::Verdict;
use crate::evidence::Error;

/// The longest that a run may be dangerous where no longer time is promised, ms.
const DANGEROUS_MS: f64 = 5.0;
/// The same of what fails on the way to the drive: until the lock is given up.
const EARLY_MS: f64 = 20.0;

/// What a start may end in, other than a drive: the checks that it has to pass, each of which has a name.
const CHECKS: core::ops::RangeInclusive<u8> = 20..=34;

/// Whether every run of a kind is as promised.
fn holds(kind: &Kind, runs: &[Tried]) -> bool {
    runs.iter().all(|run| why_not(kind, run).is_none())
}

/// Why a run is not as promised.
fn why_not(kind: &Kind, run: &Tried) -> Option<&'static str> {
    let (verdict, early) = (&run.verdict, run.place.is_early());
    // What fails on the way to the drive is calibrated away, or known at the end of the stage.
    let in_time = |most: f64| verdict.off_ms.map_or(early && !verdict.still, |off| off <= most || early);
    let named = kind.named.contains(&verdict.said) || early && CHECKS.contains(&verdict.said);
    match () {
        () if verdict.is_undetected() => Some("dangerous, and nothing is said"),
        () if verdict.dangerous_ms > kind.off_ms.unwrap_or(0.0).max(if early { EARLY_MS } else { DANGEROUS_MS }) => {
            Some("dangerous for too long")
        }
        () if kind.named.is_empty() && verdict.said != 0 && verdict.said < 96 => Some("harmless, and accused"),
        () if kind.off_ms.is_some_and(|most| !in_time(most)) => Some("not off in time"),
        () if verdict.said >= 10 && verdict.said < 96 && !named => Some("named wrongly"),
        () => None,
    }
}

/// What is missed: the first run of each kind that is not as promised, and of those without a failure.
pub(super) fn missed(tried: &[Vec<Tried>], calm: &[Tried]) -> Vec<String> {
    let of_kind = |(kind, runs): (&Kind, &Vec<Tried>)| {
        let count = runs.iter().filter(|run| why_not(kind, run).is_some()).count();
        let (run, why) = runs.iter().find_map(|run| Some((run, why_not(kind, run)?)))?;
        Some(format!(
            "{}: {count} of {} runs; the first: {}, seed {}: {why} ({})",
            kind.name,
            runs.len(),
            run.place.name,
            run.seed,
            run.verdict.said
        ))
    };
    let mut missed: Vec<String> = kinds::all().zip(tried).filter_map(of_kind).collect();
    let trips: Vec<_> = calm.iter().filter(|run| run.verdict.said != 0 || run.verdict.still).collect();
    if let Some(first) = trips.first() {
        missed.push(format!(
            "without a failure: {} of {} runs; the first: {}, seed {}",
            trips.len(),
            calm.len(),
            first.place.name,
            first.seed
        ));
    }
    missed
}

/// The tables.
pub(super) fn tables(tried: &[Vec<Tried>], calm: &[Tried]) -> Vec<TableBlock> {
    vec![by_part(tried), matrix(tried), without(calm)]
}

/// The matrix in short, by the part that fails.
fn by_part(tried: &[Vec<Tried>]) -> TableBlock {
    let mut rest = tried;
    let row = |part: &Part| {
        let (here, others) = rest.split_at(part.kinds.len());
        rest = others;
        let runs: Vec<&Tried> = here.iter().flatten().collect();
        let off: Vec<&Verdict> = runs.iter().map(|run| &run.verdict).filter(|verdict| verdict.off_ms.is_some()).collect();
        let worst = |of: &dyn Fn(&Verdict) -> f64| off.iter().map(|verdict| of(verdict)).fold(0.0, f64::max);
        let others = |holds: &dyn Fn(&Verdict) -> bool| {
            runs.iter().filter(|run| run.verdict.off_ms.is_none() && holds(&run.verdict)).count().to_string()
        };
        vec![
            part.name.to_owned(),
            here.len().to_string(),
            runs.len().to_string(),
            off.len().to_string(),
            said(runs.iter().map(|run| run.verdict.said)),
            digits(worst(&|verdict| verdict.off_ms.unwrap_or(0.0))),
            digits(worst(&|verdict| verdict.energy_j)),
            others(&|verdict| verdict.said != 0),
            others(&|verdict| verdict.said == 0 && !verdict.still),
            others(&Verdict::is_undetected),
            digits(runs.iter().map(|run| run.verdict.dangerous_ms).fold(0.0, f64::max)),
        ]
    };
    let header = [
        "part",
        "kinds",
        "runs",
        "off",
        "by fault or limit",
        "off within [ms]",
        "energy until then [J]",
        "limited",
        "harmless",
        "undetected",
        "dangerous [ms]",
    ];
    let caption = "Off: ended by a fault; within what time of the drive at worst, and with how much energy into the motional branch. Limited, harmless, undetected: not ended, as below. \
                   Dangerous: the longest time above 1.2 times the voltage limit, or more than half a bandwidth beside the resonance, before it was off.";
    TableBlock::new("parts", "Failures by the part that fails", caption, &header, PARTS.iter().map(row).collect())
}

fn matrix(tried: &[Vec<Tried>]) -> TableBlock {
    let row = |(kind, runs): (&Kind, &Vec<Tried>)| {
        let off: Vec<f64> = runs.iter().filter_map(|run| run.verdict.off_ms).collect();
        let most = |of: &dyn Fn(&Tried) -> f64| runs.iter().map(of).fold(0.0, f64::max);
        let limited = runs.iter().filter(|run| run.verdict.said >= 96).count();
        let silent = runs.iter().filter(|run| run.verdict.said == 0);
        vec![
            kind.name.to_owned(),
            kind.what.to_owned(),
            runs.len().to_string(),
            off.len().to_string(),
            if off.is_empty() { "–".into() } else { digits(off.iter().fold(0.0, |most: f64, &off| most.max(off))) },
            kind.off_ms.map_or_else(|| "–".into(), digits),
            limited.to_string(),
            silent.clone().filter(|run| !run.verdict.still).count().to_string(),
            silent.filter(|run| run.verdict.still).count().to_string(),
            digits(most(&|run| run.verdict.dangerous_ms)),
            digits(most(&|run| run.verdict.energy_j)),
            said(runs.iter().map(|run| run.verdict.said)),
            verdict(holds(kind, runs)).to_owned(),
        ]
    };
    let header = [
        "kind",
        "failure",
        "runs",
        "off",
        "worst off [ms]",
        "promised [ms]",
        "limited",
        "harmless",
        "undetected",
        "dangerous [ms]",
        "energy [J]",
        "said",
        "",
    ];
    let caption = "Off: ended by a fault, and how long it was driven after the failure at worst. Limited: the drive goes on, and a limit says so. Harmless: it goes on as it was, and \
                   nothing is said. Undetected: it goes on, more than 1.2 times above the voltage limit or more than half a bandwidth beside the resonance, and nothing is said. \
                   Dangerous: the longest time in such a state. Energy: the most into the motional branch after the failure. Said: faults and limits, and how often.";
    TableBlock::new("matrix", "Failures while the drive runs", caption, &header, kinds::all().zip(tried).map(row).collect())
}

fn said(codes: impl Iterator<Item = u8>) -> String {
    let mut counts: BTreeMap<u8, usize> = BTreeMap::new();
    codes.filter(|&code| code != 0).for_each(|code| *counts.entry(code).or_default() += 1);
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by_key(|&(code, count)| (usize::MAX - count, code));
    let each: Vec<String> = counts.iter().map(|(code, count)| format!("{code} ({count})")).collect();
    each.join(", ")
}

fn without(calm: &[Tried]) -> TableBlock {
    let row = |place: &super::Place| {
        let runs: Vec<&Tried> = calm.iter().filter(|run| run.place.name == place.name).collect();
        let said = runs.iter().filter(|run| run.verdict.said != 0).count();
        let dangerous_ms = runs.iter().map(|run| run.verdict.dangerous_ms).fold(0.0, f64::max);
        let still = runs.iter().filter(|run| run.verdict.still).count();
        vec![place.name.to_owned(), runs.len().to_string(), said.to_string(), digits(dangerous_ms), still.to_string()]
    };
    let caption = "Said: a fault has ended the run, or a limit holds in most of its end. Dangerous: the longest time in such a state, and how many runs end in it. \
                   An observer that seeks its lock drives beside the resonance, by order.";
    TableBlock::new(
        "without",
        "The same without a failure",
        caption,
        &["place", "runs", "said", "dangerous [ms]", "in the end"],
        PLACES.iter().map(row).collect(),
    )
}

/// Three digits.
pub(super) fn digits(value: f64) -> String {
    number(format!("{value:.2e}").parse().unwrap_or(value))
}

/// Each run.
pub(super) fn csv(tried: &[Vec<Tried>], calm: &[Tried]) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["kind", "place", "seed", "said", "off_ms", "energy_j", "dangerous_ms", "dangerous_in_the_end"])?;
    let kinds = kinds::all().map(|kind| kind.name).chain(["none"]);
    for (kind, runs) in kinds.zip(tried.iter().map(Vec::as_slice).chain([calm])) {
        for Tried { place, seed, verdict } in runs {
            let off = verdict.off_ms.map_or_else(String::new, |off| format!("{off:.4}"));
            writer.write_record([
                kind,
                place.name,
                &seed.to_string(),
                &verdict.said.to_string(),
                &off,
                &format!("{:.6}", verdict.energy_j),
                &format!("{:.4}", verdict.dangerous_ms),
                &verdict.still.to_string(),
            ])?;
        }
    }
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
