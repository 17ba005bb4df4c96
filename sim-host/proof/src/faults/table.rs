//! The matrix as tables, as rows of a file, and what is missed.

use std::collections::BTreeMap;

use report::{TableBlock, verdict};
use sim::numbers::number;

use super::Tried;
use super::kinds::{KINDS, Kind};
use super::place::PLACES;
use crate::evidence::Error;

/// Whether every run of a kind is as promised.
fn holds(kind: &Kind, runs: &[Tried]) -> bool {
    runs.iter().all(|run| why_not(kind, run).is_none())
}

/// Why a run is not as promised.
fn why_not(kind: &Kind, run: &Tried) -> Option<&'static str> {
    let verdict = &run.verdict;
    match () {
        () if verdict.is_undetected() => Some("dangerous, and nothing is said"),
        () if kind.named.is_empty() && verdict.said != 0 => Some("harmless, and accused"),
        () if kind.off_ms.is_some_and(|most| verdict.off_ms.is_none_or(|off| off > most)) => Some("not off in time"),
        () if verdict.said >= 10 && verdict.said < 96 && !kind.named.contains(&verdict.said) => Some("named wrongly"),
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
    let mut missed: Vec<String> = KINDS.iter().zip(tried).filter_map(of_kind).collect();
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
    vec![matrix(tried), without(calm)]
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
            said(runs),
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
    TableBlock::new("matrix", "Failures while the drive runs", caption, &header, KINDS.iter().zip(tried).map(row).collect())
}

fn said(runs: &[Tried]) -> String {
    let mut counts: BTreeMap<u8, usize> = BTreeMap::new();
    runs.iter().filter(|run| run.verdict.said != 0).for_each(|run| *counts.entry(run.verdict.said).or_default() += 1);
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by_key(|&(code, count)| (usize::MAX - count, code));
    let each: Vec<String> = counts.iter().map(|(code, count)| format!("{code} ({count})")).collect();
    each.join(", ")
}

fn without(calm: &[Tried]) -> TableBlock {
    let row = |place: &super::Place| {
        let runs: Vec<&Tried> = calm.iter().filter(|run| run.place.name == place.name).collect();
        let said = runs.iter().filter(|run| run.verdict.said != 0).count();
        let dangerous = runs.iter().filter(|run| run.verdict.dangerous_ms > 0.0).count();
        vec![place.name.to_owned(), runs.len().to_string(), said.to_string(), dangerous.to_string()]
    };
    let caption = "Said: a fault has ended the run, or a limit holds in most of its end.";
    TableBlock::new(
        "without",
        "The same without a failure",
        caption,
        &["place", "runs", "said", "dangerous"],
        PLACES.iter().map(row).collect(),
    )
}

/// Three digits.
fn digits(value: f64) -> String {
    number(format!("{value:.2e}").parse().unwrap_or(value))
}

/// Each run.
pub(super) fn csv(tried: &[Vec<Tried>], calm: &[Tried]) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["kind", "place", "seed", "said", "off_ms", "energy_j", "dangerous_ms", "dangerous_in_the_end"])?;
    let kinds = KINDS.iter().map(|kind| kind.name).chain(["none"]);
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
