//! `runs-HASH.csv`: the runs of an optimisation, from which the same command continues after an
//! interruption.
//!
//! The hash and the first line identify scene, question and version. A run is appended when it is
//! done; an incomplete last line is dropped. At the end of the search, the file is written again in
//! the order of the search, so that it is the same for any number of threads.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use super::folder::rename_synced;
use super::sweep::FolderError;
use crate::record::text_hash;
use crate::study::optimise::{Known, Question, Run, bits};
use scene::resolved::resolved_json;

/// Beginning of its first line.
const HEAD: &str = "# sim-host optimise";
/// Last column.
const FAILURE: &str = "failure";

/// File of the runs, locked for one process.
pub struct RunsFile {
    path: PathBuf,
    head: String,
    known: Known,
    file: Mutex<File>,
}

impl RunsFile {
    /// Opens the file in a folder, with the runs of an earlier process that was interrupted.
    ///
    /// # Errors
    /// If the file cannot be read or written, or another process writes it.
    pub fn open(dir: &Path, question: &Question) -> Result<Self, FolderError> {
        fs::create_dir_all(dir).map_err(write(dir))?;
        let (hash, head) = identity(question);
        let path = dir.join(format!("runs-{hash}.csv"));
        let mut file = File::options().create(true).read(true).append(true).open(&path).map_err(write(&path))?;
        if file.try_lock().is_err() {
            return Err(FolderError::Read { path, why: "another process writes it".to_owned() });
        }
        let mut text = String::new();
        if let Err(error) = file.read_to_string(&mut text) {
            return Err(FolderError::Read { path, why: error.to_string() });
        }
        // A line is complete with its end.
        let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
        if !text.is_empty() && !whole.starts_with(&head) {
            return Err(FolderError::Read { path, why: "it is not the file of this optimisation: remove it".to_owned() });
        }
        let known = whole.strip_prefix(&head).map_or_else(Known::new, |rows| read(rows, question));
        let whole = if whole.is_empty() { &head } else { whole };
        if text != *whole {
            file.set_len(0).and_then(|()| file.write_all(whole.as_bytes())).map_err(write(&path))?;
        }
        Ok(RunsFile { path, head, known, file: Mutex::new(file) })
    }

    /// Returns the runs of earlier processes.
    pub fn known(&self) -> &Known {
        &self.known
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends a run. An error is reported by [`Self::finish`], which writes all runs.
    pub fn add(&self, run: &Run) {
        if let Ok(mut file) = self.file.lock() {
            let _ = file.write_all(row(run).as_bytes());
        }
    }

    /// Writes all runs in the order of the search.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(&self, runs: &[Run]) -> Result<(), FolderError> {
        let text: String = std::iter::once(self.head.clone()).chain(runs.iter().map(row)).collect();
        let unfinished = self.path.with_extension("tmp");
        fs::write(&unfinished, text).and_then(|()| rename_synced(&unfinished, &self.path)).map_err(write(&self.path))
    }
}

fn write(path: &Path) -> impl FnOnce(std::io::Error) -> FolderError + use<> {
    let path = path.to_owned();
    |io| FolderError::Write { path, io }
}

/// Returns the hash of scene, question and version, and the first two lines: hash and columns.
fn identity(question: &Question) -> (String, String) {
    let Question { loaded, ranges, metrics, goal, limits, runs } = question;
    let asked = format!("{} {} {ranges:?} {metrics:?} {goal:?} {limits:?} {runs}", crate::VERSION, resolved_json(&loaded.scene));
    let hash = format!("{:016x}", text_hash(&asked));
    let columns: Vec<&str> = ranges.iter().map(|range| range.key.as_str()).chain(metrics.iter().map(String::as_str)).collect();
    let head = format!("{HEAD} {hash}\n{},{FAILURE}\n", columns.join(","));
    (hash, head)
}

/// Returns the line of a run. Numbers are read back exactly.
fn row(run: &Run) -> String {
    let values = run.values.iter().map(|value| format!("{value:?}"));
    let metrics = run.metrics.iter().map(|metric| metric.map_or_else(String::new, |value| format!("{value:?}")));
    let failure = run.failure.as_deref().unwrap_or_default().replace('"', "'");
    let failure = if failure.is_empty() { failure } else { format!("\"{failure}\"") };
    values.chain(metrics).chain([failure]).collect::<Vec<_>>().join(",") + "\n"
}

/// Reads runs; a line that is not a run is left out, and run again.
fn read(rows: &str, question: &Question) -> Known {
    let (keys, metrics) = (question.ranges.len(), question.metrics.len());
    let records = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(rows.as_bytes()).into_records();
    let run = |record: csv::StringRecord| {
        let cells: Vec<&str> = record.iter().collect();
        if cells.len() != keys + metrics + 1 {
            return None;
        }
        let values: Vec<f64> = cells[..keys].iter().map(|cell| cell.parse().ok()).collect::<Option<_>>()?;
        let metric = |cell: &&str| if cell.is_empty() { Some(None) } else { cell.parse().ok().map(Some) };
        let failure = Some(cells[keys + metrics]).filter(|why| !why.is_empty()).map(str::to_owned);
        Some(Run { metrics: cells[keys..keys + metrics].iter().map(metric).collect::<Option<_>>()?, failure, values })
    };
    records.filter_map(|record| run(record.ok()?)).map(|run| (bits(&run.values), run)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::optimise::Goal;

    /// An incomplete last line and a line that is not a run are run again; the others are read
    /// exactly. A file of something else is kept.
    #[test]
    fn an_interrupted_file_keeps_its_whole_runs() {
        let loaded = scene::load::load("contact-kinematic", &[]).unwrap();
        let ranges = vec!["contact.dahl.mu=0.1:0.3".parse().unwrap()];
        let metrics = vec!["friction_ratio".to_owned()];
        let question = Question { loaded: &loaded, ranges, metrics, goal: Goal::Minimise, limits: Vec::new(), runs: 100 };
        let dir = std::env::temp_dir().join(format!("sonoglide-optimise-{}", std::process::id()));
        let run = |mu: f64, ratio: Option<f64>| {
            let failure = ratio.is_none().then(|| "ends, with a \"comma\"".replace('"', "'"));
            Run { values: vec![mu], metrics: vec![ratio], failure }
        };
        let (first, second) = (run(0.1 + 0.2, Some(1.0 / 3.0)), run(0.2, None));
        let file = RunsFile::open(&dir, &question).unwrap();
        [&first, &second].iter().for_each(|run| file.add(run));
        assert!(RunsFile::open(&dir, &question).is_err());
        let path = file.path().to_owned();
        drop(file);
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, format!("{text}not,a run\n0.25,0.7")).unwrap();
        let file = RunsFile::open(&dir, &question).unwrap();
        let runs = [&first, &second].map(|run| (bits(&run.values), run.clone()));
        assert_eq!(*file.known(), Known::from(runs));
        file.finish(&[second, first]).unwrap();
        drop(file);
        assert_eq!(RunsFile::open(&dir, &question).unwrap().known().len(), 2);
        fs::write(&path, "my notes\n").unwrap();
        assert!(RunsFile::open(&dir, &question).is_err() && fs::read_to_string(&path).unwrap() == "my notes\n");
        fs::remove_dir_all(&dir).unwrap();
    }
}
