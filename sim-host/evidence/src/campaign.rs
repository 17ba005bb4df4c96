//! Shared parts of the campaigns, which judge many drawn cases of several kinds.
//!
//! ```text
//! kinds --> case by its number --> run in parallel --> judged --> tables, missed targets, CSV --> Evidence
//!           `each`                                     `count`, `worst`, `tally`, `csv`           `evidence`
//! ```

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use report::{Report, TableBlock};
use sim::numbers::number;
use sim::study::StudyError;

use crate::evidence::{Error, Evidence};

/// Judged runs of one kind.
#[derive(Clone, Debug)]
pub struct KindRuns<K, R> {
    /// Kind of the runs.
    pub kind: K,
    /// Result of each run, in order.
    pub runs: Vec<R>,
}

/// Runs and judges the cases `0..count` in parallel, until `stop` is set.
pub(crate) fn each<R: Send>(
    count: u32,
    stop: Option<&AtomicBool>,
    judge: impl Fn(u32) -> Result<R, Error> + Sync,
) -> Result<Vec<R>, Error> {
    let one = |number: u32| match stop {
        Some(stop) if stop.load(Ordering::Relaxed) => Err(StudyError::Interrupted.into()),
        _ => judge(number),
    };
    (0..count).into_par_iter().map(one).collect()
}

/// Returns the evidence of a campaign; the documentation has the tables of the page.
pub(crate) fn evidence(
    title: &str,
    subtitle: &str,
    tables: Vec<TableBlock>,
    files: Vec<(&'static str, String)>,
    missed: Vec<String>,
) -> Evidence {
    let report = Report { title: title.into(), subtitle: subtitle.into(), tables: tables.clone(), ..Report::default() };
    Evidence { report, docs: tables, files, missed, ..Evidence::default() }
}

/// Counts the runs that satisfy a condition.
pub(crate) fn count<'a, R: 'a>(runs: impl IntoIterator<Item = &'a R>, is: impl Fn(&R) -> bool) -> usize {
    runs.into_iter().filter(|run| is(run)).count()
}

/// Returns the largest of some values, none of which is below zero; zero if there are none.
pub(crate) fn worst(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

/// Counts how often each key occurs.
pub(crate) fn tally<K: Ord>(keys: impl IntoIterator<Item = K>) -> BTreeMap<K, usize> {
    let mut counts = BTreeMap::new();
    keys.into_iter().for_each(|key| *counts.entry(key).or_default() += 1);
    counts
}

/// Returns a row of cells, each formatted by its `Display`.
macro_rules! cells {
    ($($cell:expr),* $(,)?) => { vec![$($cell.to_string()),*] };
}
pub(crate) use cells;

/// Splits the column headings of a table at `" | "`.
pub(crate) fn columns(headings: &str) -> Vec<&str> {
    headings.split(" | ").collect()
}

/// Formats a value, or a dash if there is none.
pub(crate) fn or_dash<T>(value: Option<T>, format: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), format)
}

/// Formats a number with three digits, or a dash if it is not finite.
pub(crate) fn digits(value: f64) -> String {
    or_dash(Some(value).filter(|value| value.is_finite()), |value| number(format!("{value:.2e}").parse().unwrap_or(value)))
}

/// Writes a table as CSV; the column names are separated by commas.
pub(crate) fn csv(columns: &str, rows: impl IntoIterator<Item = Vec<String>>) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(columns.split(','))?;
    rows.into_iter().try_for_each(|row| writer.write_record(row))?;
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Returns the evidence of the quick variant of a bench, of `count` runs if given.
#[cfg(test)]
pub(crate) fn quick(run: fn(&mut crate::evidence::Options) -> Result<Evidence, Error>, count: Option<u32>) -> Evidence {
    let mut options =
        crate::evidence::Options { quick: true, count, seed: None, counted: None, stop: None, progress: &mut |_| () };
    run(&mut options).unwrap_or_else(|error| panic!("{error}"))
}
