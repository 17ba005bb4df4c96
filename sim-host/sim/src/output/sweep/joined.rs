//! Joining of all parts: rows as Parquet and CSV, points without a result, indices, figures and
//! page.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::parts::{self, Part};
use super::rows_file::{Layout, RowsFile, RowsWriter};
use super::{FAILURES, FolderError, INDICES, PLAN, PlanFile, ROWS, SWEEP, TABLE, page, put, write};
use crate::output::folder::replaceable;
use crate::output::parquet_file::GROUP;
use crate::output::{Folder, Owner, Presentation};
use crate::study::sweep::Rows;
use crate::study::sweep::sensitivity::{self, Sensitivity};
use report::TableBlock;
use scene::load::Assumed;

/// Maximum number of missing ranges that a message lists.
const MAX_LISTED_RANGES: usize = 4;

/// Maximum number of points whose values are returned.
const MAX_RETURNED_POINTS: u64 = 10_000;

/// Result of joining the parts of a sweep.
#[derive(Clone, Debug)]
pub struct Joined {
    /// Number of points.
    pub points: u64,
    /// Number of points without a result.
    pub failures: u64,
    /// Metrics requested by name that no point has.
    pub absent: Vec<String>,
    /// Table of the metrics and, for a sample, of the indices.
    pub tables: Vec<TableBlock>,
    /// Names of the keys and of the metrics.
    pub names: (Vec<String>, Vec<String>),
    /// Rows of all points, if these are at most 10 000.
    pub rows: Option<Rows>,
    /// Values that the user did not set.
    pub assumed: Vec<Assumed>,
    /// Path of the page.
    pub page: PathBuf,
}

/// Joins the parts in several folders, and writes the result into `target` with this presentation.
///
/// # Errors
/// If the folders contain different sweeps, if parts are missing, damaged or cannot be read, or if
/// a file cannot be written.
pub fn join(dirs: &[PathBuf], target: &Path, shown: &Presentation) -> Result<Joined, FolderError> {
    let plan = common_plan(dirs)?;
    let mut parts = dirs.iter().map(|dir| parts::list(dir)).collect::<Result<Vec<_>, _>>()?.concat();
    parts::sort(&mut parts);
    let missing = parts::gaps(0..plan.count(), &parts);
    if !missing.is_empty() {
        let ranges = missing.iter().take(MAX_LISTED_RANGES).map(|range| match range.end - range.start {
            1 => format!("{}", range.start),
            _ => format!("{} to {}", range.start, range.end - 1),
        });
        let ranges = ranges.collect::<Vec<_>>().join(", ");
        let more = missing
            .len()
            .checked_sub(MAX_LISTED_RANGES + 1)
            .map_or_else(String::new, |more| format!(" and {} more ranges", more + 1));
        let (count, missing) = (plan.count(), missing.iter().map(|range| range.end - range.start).sum());
        return Err(FolderError::Missing { missing, count, ranges: ranges + &more });
    }
    // Reads all parts: a damaged one is found before anything is written.
    let (layout, absent) = present(&plan, &parts)?;
    let owner = Owner::new(SWEEP, parts.iter().map(|part| &part.path));
    fs::create_dir_all(target).map_err(write(target))?;
    replaceable(target, &owner)?;
    if let Some(differs) = PlanFile::find(target)?.and_then(|found| plan.differs(&found)) {
        return Err(FolderError::Other { path: target.to_owned(), differs });
    }
    let path = target.join(PLAN);
    if !path.exists() {
        put(&path, plan.text().as_bytes())?;
    }
    // Only one process at a time, if the system locks files: two shards of a folder may end
    // simultaneously.
    let _alone = File::open(&path).ok().filter(|plan| plan.lock().is_ok());
    let folder = Folder::open(target, owner)?;
    let dir = folder.unfinished();
    let (failures, rows) = rows(&plan, &parts, &layout, dir)?;
    let file = RowsFile::open(&dir.join(ROWS))?;
    let indices = if plan.is_sample() { indices(&layout, &file, dir)? } else { Vec::new() };
    let written = page::write(&plan, &layout, (&file, rows.as_ref()), failures, &indices, (dir, shown))?;
    drop(file);
    folder.finish(json!({ "scene": plan.scene(), "plan_hash": plan.hash(), "complete": true }))?;
    let names = (layout.keys, layout.metrics);
    let (assumed, page) = (plan.assumed(), target.join(super::PAGE));
    Ok(Joined { points: plan.count(), failures, absent, tables: written, names, rows, assumed, page })
}

/// Returns the common plan of all folders.
fn common_plan(dirs: &[PathBuf]) -> Result<PlanFile, FolderError> {
    let mut first: Option<(&PathBuf, PlanFile)> = None;
    for dir in dirs {
        let plan = PlanFile::find(dir)?.ok_or_else(|| FolderError::None { path: dir.clone() })?;
        match &first {
            None => first = Some((dir, plan)),
            Some((other, of)) => {
                if let Some(differs) = of.differs(&plan) {
                    return Err(FolderError::Different { first: (*other).clone(), second: dir.clone(), differs });
                }
            }
        }
    }
    first.map(|(_, plan)| plan).ok_or_else(|| FolderError::None { path: PathBuf::new() })
}

/// Returns the columns of the result, and the metrics requested by name that no point has. If all
/// metrics were requested, only those that a point has are columns.
fn present(plan: &PlanFile, parts: &[Part]) -> Result<(Layout, Vec<String>), FolderError> {
    let mut some = BTreeSet::new();
    for part in parts {
        let file = plan.check(part)?;
        let found = plan.layout().metrics.iter().filter(|metric| !some.contains(*metric) && file.present(metric) > 0);
        let found: Vec<String> = found.cloned().collect();
        some.extend(found);
    }
    let (metrics, absent): (Vec<String>, Vec<String>) =
        plan.layout().metrics.iter().cloned().partition(|metric| some.contains(metric));
    let keys = plan.layout().keys.clone();
    if plan.is_of_all_metrics() {
        return Ok((Layout { keys, metrics }, Vec::new()));
    }
    Ok((plan.layout().clone(), absent))
}

/// Writes all rows, and separately those without a result; returns the number of the latter, and
/// the rows if they are few.
fn rows(plan: &PlanFile, parts: &[Part], layout: &Layout, target: &Path) -> Result<(u64, Option<Rows>), FolderError> {
    let mut file = RowsWriter::create(&target.join(ROWS), layout, plan.hash(), false)?;
    let heads: Vec<&str> = ["point"].into_iter().chain(layout.keys.iter().map(String::as_str)).collect();
    let mut table = Text::create(target.join(TABLE), Rows::head(&layout.keys, &layout.metrics))?;
    let mut without = Text::create(target.join(FAILURES), heads.iter().copied().chain(["failure"]))?;
    let places: Vec<usize> =
        layout.metrics.iter().filter_map(|name| plan.layout().metrics.iter().position(|metric| metric == name)).collect();
    let mut failures = 0;
    let mut next = 0;
    let mut waiting = Rows::new(layout.keys.len(), layout.metrics.len());
    let mut kept = (plan.count() <= MAX_RETURNED_POINTS).then(|| waiting.clone());
    for part in parts {
        let opened = plan.check(part)?;
        let mut points = part.points.clone();
        for group in 0..opened.groups() {
            let mut rows = opened.rows(group, plan.layout())?;
            if !rows.points.iter().all(|&point| points.next() == Some(point as u64)) {
                return Err(FolderError::Part { path: part.path.clone() });
            }
            rows.metrics = places.iter().map(|&place| std::mem::take(&mut rows.metrics[place])).collect();
            // Parts may overlap; their common rows are identical.
            let first = rows.points.partition_point(|&point| (point as u64) < next);
            rows.drop_first(first);
            next += rows.points.len() as u64;
            failures += text(&rows, &mut table, &mut without)?;
            if let Some(kept) = &mut kept {
                kept.append(rows.clone());
            }
            waiting.append(rows);
            while waiting.points.len() >= GROUP {
                let rest = waiting.split_off(GROUP);
                file.write(&waiting)?;
                waiting = rest;
            }
        }
    }
    file.write(&waiting)?;
    table.finish()?;
    without.finish()?;
    file.finish()?;
    Ok((failures, kept))
}

fn text(rows: &Rows, table: &mut Text, without: &mut Text) -> Result<u64, FolderError> {
    let mut failures = 0;
    for row in 0..rows.points.len() {
        table.row(rows.cells(row))?;
        if let Some(why) = &rows.failures[row] {
            without.row(rows.point_cells(row).chain([why.clone()]))?;
            failures += 1;
        }
    }
    Ok(failures)
}

/// Computes the Sobol indices of each metric that has some, and writes them as a table.
fn indices(layout: &Layout, file: &RowsFile, target: &Path) -> Result<Vec<(String, Sensitivity)>, FolderError> {
    let mut all = Vec::new();
    for metric in &layout.metrics {
        let found = sensitivity::compute(layout.keys.len(), &file.column(metric)?);
        all.extend(found.map(|found| (metric.clone(), found)));
    }
    let mut table = Text::create(
        target.join(INDICES),
        [
            "metric",
            "key",
            "first_order",
            "first_order_lower",
            "first_order_upper",
            "total",
            "total_lower",
            "total_upper",
            "draws",
        ],
    )?;
    for (metric, found) in &all {
        for (key, indices) in layout.keys.iter().zip(&found.keys) {
            let estimates = [indices.first, indices.total].map(|of| [of.value, of.interval.0, of.interval.1]).concat();
            let row = [metric.clone(), key.clone()].into_iter().chain(estimates.iter().map(|value| format!("{value:?}")));
            table.row(row.chain([found.used.to_string()]))?;
        }
    }
    table.finish()?;
    Ok(all)
}

/// CSV writer with its path, for messages.
struct Text {
    path: PathBuf,
    writer: csv::Writer<BufWriter<File>>,
}

impl Text {
    fn create<'a>(path: PathBuf, head: impl IntoIterator<Item = &'a str>) -> Result<Self, FolderError> {
        let file = File::create(&path).map_err(write(&path))?;
        let mut text = Text { path, writer: csv::Writer::from_writer(BufWriter::new(file)) };
        text.row(head.into_iter().map(str::to_owned))?;
        Ok(text)
    }

    fn row(&mut self, cells: impl IntoIterator<Item = String>) -> Result<(), FolderError> {
        self.writer.write_record(cells).map_err(|error| write(&self.path)(error.into()))
    }

    fn finish(mut self) -> Result<(), FolderError> {
        self.writer.flush().map_err(write(&self.path))
    }
}
