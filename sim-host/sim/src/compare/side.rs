//! One side of a comparison: the folder of a run, or a file of measured metrics.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::{CompareError, figures};
use crate::output::checksum;
use columns::file;
use scene::metrics;

/// Value of a metric.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredMetric {
    /// Name of the metric.
    pub metric: String,
    /// Value of the metric.
    pub value: f64,
    /// Standard deviation of the value, if known.
    pub sd: Option<f64>,
}

/// A result to compare.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// Path as given by the user.
    pub label: String,
    /// Values of its metrics.
    pub metrics: Vec<MeasuredMetric>,
    /// Hash of the drive codes, if any were played.
    pub drive_hash: Option<String>,
    /// Level and version of the run; `None` for a measurement.
    level: Option<(String, String)>,
    /// Folder of its figures; `None` for a measurement.
    pub(super) folder: Option<PathBuf>,
}

impl Side {
    /// Reads the folder of a run, or a table with the columns `metric`, `value` and optionally
    /// `sd`.
    ///
    /// # Errors
    /// If it is neither, or if a line of it cannot be read.
    pub fn read(path: &Path) -> Result<Self, CompareError> {
        if path.is_dir() { of_folder(path) } else { of_file(path) }
    }

    /// Returns the value of a metric.
    pub fn metric(&self, name: &str) -> Option<&MeasuredMetric> {
        self.metrics.iter().find(|measured| measured.metric == name)
    }

    /// Describes the result in words.
    pub(super) fn description(&self) -> String {
        match &self.level {
            Some((level, version)) => format!("{} ({level}; version {version})", self.label),
            None => format!("{} (a measurement)", self.label),
        }
    }

    pub(super) fn json(&self) -> Value {
        let (level, version) = self.level.clone().unzip();
        json!({ "path": self.label, "level": level, "version": version, "drive_hash": self.drive_hash })
    }
}

fn of_folder(path: &Path) -> Result<Side, CompareError> {
    let label = path.display().to_string();
    let no_result = |why: String| CompareError::NoResult { path: label.clone(), why };
    let read = |name: &str| -> Result<Value, CompareError> {
        let bytes = file::read(&path.join(name), file::MAX_DATA_BYTES)
            .map_err(|error| no_result(format!("contains no run: {name}: {error}")))?;
        serde_json::from_slice(&bytes).map_err(|error| no_result(format!("contains no run: {name} cannot be read: {error}")))
    };
    let manifest = read("manifest.json")?;
    if manifest["complete"] != json!(true) {
        return Err(no_result("contains an incomplete run: it was interrupted, or is still being written".into()));
    }
    for file in figures::files(path).into_values().chain([path.join("summary.json")]) {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let known = manifest["checksums"][&*name].as_str();
        if fs::File::open(&file).and_then(checksum).is_ok_and(|sum| known.is_some_and(|known| known != sum)) {
            return Err(no_result(format!(
                "contains a changed run: {name} does not match its checksum in manifest.json. Repeat the run, or delete this \
                 checksum to use the file as it is"
            )));
        }
    }
    let summary = read("summary.json")?;
    let text = |value: &Value| value.as_str().map(str::to_owned);
    let metrics =
        summary["metrics"].as_object().ok_or_else(|| no_result("contains no run: summary.json has no metrics".into()))?;
    // An infinite statistic is written as null.
    let measured = |(name, value): (&String, &Value)| MeasuredMetric {
        metric: name.clone(),
        value: value.as_f64().unwrap_or(f64::INFINITY),
        sd: None,
    };
    Ok(Side {
        metrics: metrics.iter().map(measured).collect(),
        drive_hash: text(&summary["drive_hash"]),
        level: text(&manifest["level"]).zip(text(&manifest["version"])),
        folder: Some(path.to_owned()),
        label,
    })
}

fn of_file(path: &Path) -> Result<Side, CompareError> {
    let label = path.display().to_string();
    let no_result = |why: String| CompareError::NoResult { path: label.clone(), why };
    let bytes = file::read(path, file::MAX_DATA_BYTES).map_err(|error| no_result(format!("cannot be read: {error}")))?;
    let at = |line: usize, why: String| CompareError::Line { file: label.clone(), line: line as u64, why };
    let table = columns::parse(&bytes, None).map_err(|error| match error.line() {
        Some(line) => at(line, error.to_string()),
        None => no_result(format!("is neither the folder of a run nor a file of measured metrics: {error}")),
    })?;
    let names = table.headings();
    let is = |heading: &str, name: &str| heading.trim().eq_ignore_ascii_case(name);
    let column = |name: &str| names.iter().position(|heading| is(heading, name)).map(|at| &table.columns[at]);
    let (Some(metric), Some(value)) = (column("metric"), column("value")) else {
        return Err(no_result(format!(
            "is neither the folder of a run nor a file of measured metrics, which has the columns metric, value and optionally \
             sd; it has `{}`",
            names.join("`, `")
        )));
    };
    if let Some(other) = names.iter().find(|heading| !["metric", "value", "sd"].iter().any(|known| is(heading, known))) {
        return Err(no_result(format!(
            "has the column `{}`, which is not known; give metric, value in the unit of the metric, and optionally sd",
            columns::beginning(other)
        )));
    }
    let sd = column("sd");
    let mut metrics: Vec<MeasuredMetric> = Vec::new();
    for (row, &number) in value.values.iter().enumerate() {
        let at = |why: String| at(table.lines.get(row).map_or(row + 1, |line| *line), why);
        let name = metrics::known(metric.word(row).unwrap_or_default()).map_err(at)?;
        if metrics.iter().any(|measured| measured.metric == name) {
            return Err(at(format!("`{name}` occurs twice")));
        }
        let cell = |word: &str| at(format!("`{}` is not a number", columns::beginning(word)));
        if let Some(word) = value.word(row) {
            return Err(cell(word));
        }
        let sd = match sd.and_then(|sd| sd.word(row)) {
            None => sd.map(|sd| sd.values[row]),
            Some("") => None,
            Some(word) => return Err(cell(word)),
        };
        if let Some(sd) = sd.filter(|sd| *sd < 0.0) {
            return Err(at(format!("the standard deviation {sd} is negative")));
        }
        metrics.push(MeasuredMetric { metric: name.to_owned(), value: number, sd });
    }
    Ok(Side { label, metrics, drive_hash: None, level: None, folder: None })
}
