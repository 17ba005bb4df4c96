//! The folder of a sweep: its plan, its parts, and when it is complete its rows as Parquet and CSV, with figures and a page.
//!
//! ```text
//! plan.json --> points of this shard that no part has --> chunks (run in parallel) --> part-FIRST-END.parquet
//!               all parts, in order --> sweep.parquet, sweep.csv, failures.csv --> indices.csv, figures, report.html
//! ```
//!
//! A part is written under another name and renamed when it is whole, so that whatever ends the process costs the chunk that it was at: the same
//! call again goes on behind it. All other files are one result of a [`Folder`](super::Folder), which a sweep replaces only if nobody has changed it. Rows follow from the plan alone, so that what is joined is the same, byte for byte, however it was divided.

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

/// The plan.
pub(super) const PLAN: &str = "plan.json";
/// Command that owns the folder.
pub(super) const SWEEP: &str = "sweep";
/// Why points have no result.
const FAILURES: &str = "failures.csv";
/// All rows.
const ROWS: &str = "sweep.parquet";
/// All rows, as text.
const TABLE: &str = "sweep.csv";
/// Sobol indices of a sample.
const INDICES: &str = "indices.csv";
/// The page.
const PAGE: &str = "report.html";
/// What a file that is being written ends in.
const UNFINISHED: &str = ".tmp";
/// How long a chunk is to take: what is lost when a process is killed.
const CHUNK: Duration = Duration::from_secs(10);
/// Fewest points of a chunk for each thread, so that threads seldom wait for the last of them.
const PER_THREAD: u64 = 16;

/// Bytes of a megabyte.
const MB: f64 = 1e6;

/// What went wrong with the folder of a sweep.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// A file cannot be written.
    #[error("cannot write `{}`: {io}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        io: io::Error,
    },
    /// A file cannot be read.
    #[error("cannot read `{}`: {why}", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// The folder holds another sweep.
    #[error("`{}` holds another sweep, {differs}: choose another folder with -o, or remove it", path.display())]
    Other {
        /// The folder.
        path: PathBuf,
        /// In what it differs.
        differs: String,
    },
    /// The folder has a file of a sweep, and no plan that says of which.
    #[error("`{}` is there already, and no {PLAN} says of which sweep it is: remove it, or choose another folder with -o", path.display())]
    Strange {
        /// The file.
        path: PathBuf,
    },
    /// The result has no room.
    #[error("{points} points take at least {:.1} MB, and `{}` has room for {:.1} MB: choose another folder with -o, or fewer points or metrics", *least as f64 / MB, path.display(), *room as f64 / MB)]
    Room {
        /// The folder.
        path: PathBuf,
        /// How many points are still to be run.
        points: u64,
        /// Bytes that they take at the least.
        least: u64,
        /// Bytes that are free.
        room: u64,
    },
    /// Another process is at the same shard.
    #[error("another process is at shard {shard} of the sweep in `{}`: wait for its end", path.display())]
    Held {
        /// The folder.
        path: PathBuf,
        /// The shard.
        shard: Shard,
    },
    /// There is no sweep in a folder.
    #[error("there is no sweep in `{}`: it has no {PLAN}", path.display())]
    None {
        /// The folder.
        path: PathBuf,
    },
    /// Folders are of different sweeps.
    #[error("`{}` and `{}` are of different sweeps, {differs}", first.display(), second.display())]
    Different {
        /// A folder.
        first: PathBuf,
        /// Another folder.
        second: PathBuf,
        /// In what they differ.
        differs: String,
    },
    /// Parts are missing.
    #[error("{missing} of {count} points are missing: {ranges}. Run their shards to the end, and name all their folders")]
    Missing {
        /// How many points are missing.
        missing: u64,
        /// How many there are.
        count: u64,
        /// Which they are.
        ranges: String,
    },
    /// A part is not of this sweep, or has other rows than its name says.
    #[error("`{}` is no part of this sweep: remove it, and run the sweep again", path.display())]
    Part {
        /// Its file.
        path: PathBuf,
    },
    /// The result cannot be written, or may not replace what the folder holds.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The points cannot be run.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A figure or the page.
    #[error(transparent)]
    Report(#[from] ReportError),
}

/// The folder of a sweep, held for one of its shards.
pub struct SweepFolder {
    dir: PathBuf,
    plan: PlanFile,
    shard: Shard,
    lock: PathBuf,
    _living: File,
}

impl SweepFolder {
    /// Makes the folder ready for a shard of a sweep that reads `inputs` and its scene, or takes up what it holds of this sweep.
    ///
    /// # Errors
    /// If the folder holds another sweep or another result, a changed file or an input, or another process is at this shard.
    pub fn open(dir: &Path, sweep: &Sweep, shard: Shard, inputs: &[PathBuf]) -> Result<Self, FolderError> {
        let plan = PlanFile::new(sweep);
        fs::create_dir_all(dir).map_err(write(dir))?;
        replaceable(dir, &Owner::new(SWEEP, [inputs, &sweep.loaded.files()].concat()))?;
        let path = dir.join(PLAN);
        let found = PlanFile::find(dir)?;
        if let Some(differs) = found.as_ref().and_then(|found| plan.differs(found)) {
            return Err(FolderError::Other { path: dir.to_owned(), differs });
        }
        let left = shard.missing(plan.count(), &parts::of(dir)?).iter().map(|range| range.end - range.start).sum();
        // Of all metrics a scene has one at the least.
        let metrics = if sweep.all { 1 } else { plan.layout().metrics.len() };
        has_room(dir, left, plan.layout().keys.len() + metrics)?;
        match found {
            Some(_) => {}
            None => {
                let own = [FAILURES, ROWS, TABLE, INDICES, PAGE].map(|name| dir.join(name));
                let parts = parts::of(dir)?.into_iter().map(|part| part.path);
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
        // Nobody else writes parts of this shard.
        parts::unfinished(dir, shard, plan.count())?.iter().for_each(|path| {
            let _ = fs::remove_file(path);
        });
        Ok(SweepFolder { dir: dir.to_owned(), plan, shard, lock, _living: living })
    }

    /// How many points of this shard are still to be run.
    ///
    /// # Errors
    /// If a part in the folder cannot be read or is not of this sweep.
    pub fn left(&self) -> Result<u64, FolderError> {
        Ok(self.missing()?.iter().map(|range| range.end - range.start).sum())
    }

    /// The points of this shard that are still to be run, in ranges.
    ///
    /// # Errors
    /// If a part in the folder cannot be read or is not of this sweep.
    pub fn missing(&self) -> Result<Vec<std::ops::Range<u64>>, FolderError> {
        let parts = parts::of(&self.dir)?;
        parts.iter().try_for_each(|part| self.plan.check(part).map(drop))?;
        Ok(self.shard.missing(self.plan.count(), &parts))
    }

    /// Runs what is missing of this shard, chunk by chunk, until it is stopped; whether it is complete. `done` is called after each point.
    ///
    /// # Errors
    /// If the scene cannot be run at all, or a part cannot be written.
    pub fn run(&self, sweep: &Sweep, stop: &AtomicBool, done: &(dyn Fn() + Sync)) -> Result<bool, FolderError> {
        let fewest = PER_THREAD * rayon::current_num_threads() as u64;
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
                // Towards the duration of a chunk, at most eight times as many as the last had.
                let rate = (points.end - points.start) as f64 / began.elapsed().as_secs_f64().max(1e-9);
                size = ((rate * CHUNK.as_secs_f64()) as u64).min(8 * size).clamp(fewest, GROUP as u64);
                if stop.load(Ordering::Relaxed) {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Whether the folder has all points of the sweep, those of other shards as well.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn is_whole(&self) -> Result<bool, FolderError> {
        Ok(parts::gaps(0..self.plan.count(), &parts::of(&self.dir)?).is_empty())
    }
}

impl Drop for SweepFolder {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.lock);
    }
}

/// Whether so many points of so many numbers have room in a folder, by the least that these take: 8 bytes each, in one of the three files that they go to.
fn has_room(dir: &Path, points: u64, columns: usize) -> Result<(), FolderError> {
    let least = points.saturating_mul(columns as u64).saturating_mul(size_of::<f64>() as u64);
    let room = fs4::available_space(dir).map_err(|io| read(dir)(io))?;
    if room < least {
        return Err(FolderError::Room { path: dir.to_owned(), points, least, room });
    }
    Ok(())
}

/// What a file is called until it is whole: each process has a name of its own.
fn unfinished(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{name}.{}{UNFINISHED}", std::process::id()))
}

/// Writes a file as a whole.
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
    fn what_has_no_room_is_refused() {
        let dir = std::env::temp_dir();
        assert!(has_room(&dir, 1000, 2).is_ok());
        // A hundred thousand petabytes.
        let refused = has_room(&dir, 6_250_000_000_000_000_000, 2).map_err(|error| error.to_string());
        let begins = "6250000000000000000 points take at least 18446744073709.6 MB, and `";
        assert!(refused.is_err_and(|error| error.starts_with(begins)));
    }
}
