//! Folder of a sweep: its plan and its parts and, when it is complete, its rows as Parquet and CSV,
//! with figures and a page.
//!
//! ```text
//! plan.json --> missing points of this shard --> chunks (run in parallel) --> part-FIRST-END.parquet
//!               all parts, in order --> sweep.parquet, sweep.csv, failures.csv --> indices.csv, figures, report.html
//! ```
//!
//! A part is written under a temporary name and renamed when it is complete. If the process ends
//! for any reason, only the current chunk is lost: the same call resumes after it. All other files
//! are one result of a [`Folder`](super::Folder), which a sweep replaces only if it is unchanged.
//! Rows depend only on the plan, so the joined result is identical, byte for byte, for any division
//! into shards.

mod joined;
mod page;
mod parts;
mod plan_file;
mod rows_file;

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use report::ReportError;

pub use self::joined::{Joined, join};
pub use self::parts::{Part, Shard};
pub use self::plan_file::PlanFile;
pub use self::rows_file::{Layout, RowsFile};
use super::OutputError;
use super::folder::{Owner, replaceable};
use super::parquet_file::GROUP;
use crate::study::StudyError;
use crate::study::sweep::Sweep;

/// Plan of the sweep.
pub(super) const PLAN: &str = "plan.json";
/// Command that owns the folder.
pub(super) const SWEEP: &str = "sweep";
/// Points without a result, with reasons.
const FAILURES: &str = "failures.csv";
/// All rows.
const ROWS: &str = "sweep.parquet";
/// All rows, as text.
const TABLE: &str = "sweep.csv";
/// Sobol indices of a sample.
const INDICES: &str = "indices.csv";
/// Page of the sweep.
const PAGE: &str = "report.html";
/// Suffix of a file that is being written.
const UNFINISHED: &str = ".tmp";
/// Target duration of a chunk, which is lost when a process is killed.
const CHUNK_TIME: Duration = Duration::from_secs(10);
/// Minimum number of points of a chunk per thread, so that threads seldom wait for the last of
/// them.
const MIN_POINTS_PER_THREAD: u64 = 16;

/// Megabyte, bytes.
const MB: f64 = 1e6;

/// Error of the folder of a sweep.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// A file cannot be written.
    #[error("cannot write `{}`: {io}", path.display())]
    Write {
        /// File or folder.
        path: PathBuf,
        /// Reason.
        io: io::Error,
    },
    /// A file cannot be read.
    #[error("cannot read `{}`: {why}", path.display())]
    Read {
        /// File or folder.
        path: PathBuf,
        /// Reason.
        why: String,
    },
    /// The folder contains another sweep.
    #[error("`{}` contains another sweep ({differs}): choose another folder with -o, or remove it", path.display())]
    Other {
        /// Folder.
        path: PathBuf,
        /// Difference.
        differs: String,
    },
    /// The folder contains a file of a sweep, but no plan.
    #[error("`{}` already exists, but there is no {PLAN} that identifies its sweep: remove it, or choose another folder with \
             -o", path.display())]
    Strange {
        /// File.
        path: PathBuf,
    },
    /// There is not enough space for the result.
    #[error("{points} points take at least {:.1} MB, but `{}` has only {:.1} MB free: choose another folder with -o, or fewer \
             points or metrics", *least as f64 / MB, path.display(), *room as f64 / MB)]
    Room {
        /// Folder.
        path: PathBuf,
        /// Number of points that remain to be run.
        points: u64,
        /// Minimum size of the result, bytes.
        least: u64,
        /// Free space, bytes.
        room: u64,
    },
    /// Another process runs the same shard.
    #[error("another process runs shard {shard} of the sweep in `{}`: wait until it ends", path.display())]
    Held {
        /// Folder.
        path: PathBuf,
        /// Shard.
        shard: Shard,
    },
    /// There is no sweep in a folder.
    #[error("there is no sweep in `{}`: it has no {PLAN}", path.display())]
    None {
        /// Folder.
        path: PathBuf,
    },
    /// Folders contain different sweeps.
    #[error("`{}` and `{}` contain different sweeps ({differs})", first.display(), second.display())]
    Different {
        /// First folder.
        first: PathBuf,
        /// Second folder.
        second: PathBuf,
        /// Difference.
        differs: String,
    },
    /// Parts are missing.
    #[error("{missing} of {count} points are missing: {ranges}. Complete their shards, and name all their folders")]
    Missing {
        /// Number of missing points.
        missing: u64,
        /// Number of points.
        count: u64,
        /// Ranges of missing points.
        ranges: String,
    },
    /// A part belongs to another sweep, or its rows do not match its name.
    #[error("`{}` is not a valid part of this sweep: remove it, and run the sweep again", path.display())]
    Part {
        /// File of the part.
        path: PathBuf,
    },
    /// The result cannot be written, or may not replace the contents of the folder.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The points cannot be run.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A figure or the page cannot be written.
    #[error(transparent)]
    Report(#[from] ReportError),
}

/// Folder of a sweep, locked for one of its shards.
pub struct SweepFolder {
    dir: PathBuf,
    plan: PlanFile,
    shard: Shard,
    lock: PathBuf,
    _living: File,
}

impl SweepFolder {
    /// Prepares the folder for a shard of a sweep that reads `inputs` and its scene, or resumes
    /// this sweep in it.
    ///
    /// # Errors
    /// If the folder contains another sweep or another result, a changed file or an input, or if
    /// another process runs this shard.
    pub fn open(dir: &Path, sweep: &Sweep, shard: Shard, inputs: &[PathBuf]) -> Result<Self, FolderError> {
        let plan = PlanFile::new(sweep);
        fs::create_dir_all(dir).map_err(write(dir))?;
        replaceable(dir, &Owner::new(SWEEP, [inputs, &sweep.loaded.files()].concat()))?;
        let path = dir.join(PLAN);
        let found = PlanFile::find(dir)?;
        if let Some(differs) = found.as_ref().and_then(|found| plan.differs(found)) {
            return Err(FolderError::Other { path: dir.to_owned(), differs });
        }
        let left = shard.missing(plan.count(), &parts::list(dir)?).iter().map(|range| range.end - range.start).sum();
        // With all metrics, a scene has at least one.
        let metrics = if sweep.all { 1 } else { plan.layout().metrics.len() };
        has_room(dir, left, plan.layout().keys.len() + metrics)?;
        match found {
            Some(_) => {}
            None => {
                let own = [FAILURES, ROWS, TABLE, INDICES, PAGE].map(|name| dir.join(name));
                let parts = parts::list(dir)?.into_iter().map(|part| part.path);
                if let Some(path) = own.into_iter().filter(|path| path.symlink_metadata().is_ok()).chain(parts).next() {
                    return Err(FolderError::Strange { path });
                }
                put(&path, plan.text().as_bytes())?;
            }
        }
        let lock = dir.join(format!(".shard-{}", shard.to_string().replace('/', "-of-")));
        let living = File::create(&lock).map_err(write(&lock))?;
        if living.try_lock().is_err() {
            return Err(FolderError::Held { path: dir.to_owned(), shard });
        }
        // No other process writes parts of this shard.
        parts::unfinished(dir, shard, plan.count())?.iter().for_each(|path| {
            let _ = fs::remove_file(path);
        });
        Ok(SweepFolder { dir: dir.to_owned(), plan, shard, lock, _living: living })
    }

    /// Returns the number of points of this shard that remain to be run.
    ///
    /// # Errors
    /// If a part in the folder cannot be read or belongs to another sweep.
    pub fn left(&self) -> Result<u64, FolderError> {
        Ok(self.missing()?.iter().map(|range| range.end - range.start).sum())
    }

    /// Returns the ranges of points of this shard that remain to be run.
    ///
    /// # Errors
    /// If a part in the folder cannot be read or belongs to another sweep.
    pub fn missing(&self) -> Result<Vec<std::ops::Range<u64>>, FolderError> {
        let parts = parts::list(&self.dir)?;
        parts.iter().try_for_each(|part| self.plan.check(part).map(drop))?;
        Ok(self.shard.missing(self.plan.count(), &parts))
    }

    /// Runs the missing points of this shard, chunk by chunk, until it is stopped; returns `true`
    /// if the shard is complete. `done` is called after each point.
    ///
    /// # Errors
    /// If the scene cannot be run at all, or a part cannot be written.
    pub fn run(&self, sweep: &Sweep, stop: &AtomicBool, done: &(dyn Fn() + Sync)) -> Result<bool, FolderError> {
        let fewest = MIN_POINTS_PER_THREAD * rayon::current_num_threads() as u64;
        let mut size = fewest;
        for range in self.missing()? {
            let mut next = range.start;
            while next < range.end {
                let points = next..range.end.min(next + size);
                let began = Instant::now();
                if self.plan.write_part(sweep, points.clone(), &self.dir, (stop, done))?.is_none() {
                    return Ok(false);
                }
                next = points.end;
                // The next size approaches the target duration, by at most a factor of eight.
                let rate = (points.end - points.start) as f64 / began.elapsed().as_secs_f64().max(1e-9);
                size = ((rate * CHUNK_TIME.as_secs_f64()) as u64).min(8 * size).clamp(fewest, GROUP as u64);
                if stop.load(Ordering::Relaxed) {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Returns `true` if the folder has all points of the sweep, including those of other shards.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn is_whole(&self) -> Result<bool, FolderError> {
        Ok(parts::gaps(0..self.plan.count(), &parts::list(&self.dir)?).is_empty())
    }
}

impl Drop for SweepFolder {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.lock);
    }
}

/// Checks the space in a folder for `points` rows of `columns` numbers. The minimum is 8 bytes
/// each, in one of the three files with all rows.
fn has_room(dir: &Path, points: u64, columns: usize) -> Result<(), FolderError> {
    let least = points.saturating_mul(columns as u64).saturating_mul(size_of::<f64>() as u64);
    let room = fs4::available_space(dir).map_err(|io| read(dir)(io))?;
    if room < least {
        return Err(FolderError::Room { path: dir.to_owned(), points, least, room });
    }
    Ok(())
}

/// Returns the temporary name of a file until it is complete, which is unique to the process.
fn unfinished(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{name}.{}{UNFINISHED}", std::process::id()))
}

/// Writes a file atomically.
fn put(path: &Path, bytes: &[u8]) -> Result<(), FolderError> {
    let unfinished = unfinished(path);
    let put = fs::write(&unfinished, bytes).and_then(|()| fs::rename(&unfinished, path));
    put.map_err(|io| {
        let _ = fs::remove_file(&unfinished);
        write(path)(io)
    })
}

fn write(path: &Path) -> impl FnOnce(io::Error) -> FolderError + use<> {
    let path = path.to_owned();
    |io| FolderError::Write { path, io }
}

fn read(path: &Path) -> impl FnOnce(io::Error) -> FolderError + use<> {
    let path = path.to_owned();
    move |io| FolderError::Read { path, why: io.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn result_without_disk_space_is_refused() {
        let dir = std::env::temp_dir();
        assert!(has_room(&dir, 1000, 2).is_ok());
        // 1e20 bytes, a hundred thousand petabytes.
        let refused = has_room(&dir, 6_250_000_000_000_000_000, 2).map_err(|error| error.to_string());
        let begins = "6250000000000000000 points take at least 18446744073709.6 MB, but `";
        assert!(refused.is_err_and(|error| error.starts_with(begins)));
    }
}
