//! Folder of a sweep: its plan and its parts and, when it is complete, its rows as Parquet and CSV,
//! with figures and a page.
//!
//! ```text
//! plan.json --> missing points of this shard --> chunks (run in parallel) --> part-FIRST-END-CHECKSUM.parquet
//!               all parts, in order --> sweep.parquet, sweep.csv, failures.csv --> indices.csv, figures, report.html
//! ```
//!
//! A part is written under a temporary name and renamed when it is complete. If the process ends
//! for any reason, only the current chunk is lost: the same call resumes after it. It also runs the
//! points of a part whose bytes do not match the checksum in its name. All other files are one
//! result of a [`Folder`](super::Folder), which a sweep replaces only if it is unchanged. Rows
//! depend only on the plan, so the joined result is identical, byte for byte, for any division into
//! shards.

mod folder_error;
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

pub use self::folder_error::FolderError;
pub use self::joined::{Joined, join};
pub use self::parts::{Part, Shard};
pub use self::plan_file::PlanFile;
pub use self::rows_file::{Layout, RowsFile};
use super::folder::{Owner, is_alive, locked, rename_synced, replaceable};
use super::parquet_file::GROUP;
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
/// Prefix of the file that a process locks while it runs a shard.
const LOCK: &str = ".shard-";
/// Separator of number and count in the name of such a file.
const LOCK_OF: &str = "-of-";
/// Suffix of a file that is being written.
const UNFINISHED: &str = ".tmp";
/// Target duration of a chunk, which is lost when a process is killed.
const CHUNK_TIME: Duration = Duration::from_secs(10);
/// Minimum number of points of a chunk per thread, so that threads seldom wait for the last of
/// them.
const MIN_POINTS_PER_THREAD: u64 = 16;

/// Folder of a sweep, locked for one of its shards.
pub struct SweepFolder {
    dir: PathBuf,
    plan: PlanFile,
    shard: Shard,
    damaged: Vec<String>,
    lock: PathBuf,
    _living: File,
}

impl SweepFolder {
    /// Prepares the folder for a shard of a sweep that reads `inputs` and its scene, or resumes
    /// this sweep in it. Removes damaged parts with points of the shard.
    ///
    /// # Errors
    /// If the folder contains another sweep or another result, a changed file or an input, or if
    /// another process runs points of this shard.
    pub fn open(dir: &Path, sweep: &Sweep, shard: Shard, inputs: &[PathBuf]) -> Result<Self, FolderError> {
        let plan = PlanFile::new(sweep);
        fs::create_dir_all(dir).map_err(write(dir))?;
        // Two processes must not examine the locks of the shards at the same time.
        let alone = locked(dir);
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
        if let Some(running) = running(dir, shard, plan.count())? {
            return Err(FolderError::Held { path: dir.to_owned(), running, shard });
        }
        if found.is_none() {
            let own = [FAILURES, ROWS, TABLE, INDICES, PAGE].map(|name| dir.join(name));
            let parts = parts::list(dir)?.into_iter().map(|part| part.path);
            if let Some(path) = own.into_iter().filter(|path| path.symlink_metadata().is_ok()).chain(parts).next() {
                return Err(FolderError::Strange { path });
            }
            put(&path, plan.text().as_bytes())?;
        }
        let lock = dir.join(format!("{LOCK}{}", shard.to_string().replace('/', LOCK_OF)));
        let living = File::create(&lock).map_err(write(&lock))?;
        if living.try_lock().is_err() {
            return Err(FolderError::Held { path: dir.to_owned(), running: shard, shard });
        }
        let mut folder = SweepFolder { dir: dir.to_owned(), plan, shard, damaged: Vec::new(), lock, _living: living };
        let damaged = folder.remove_damaged();
        // An error below drops the folder, which needs this lock.
        drop(alone);
        folder.damaged = damaged?;
        // No other process writes parts of this shard.
        parts::unfinished(dir, shard, folder.plan.count())?.iter().for_each(|path| {
            let _ = fs::remove_file(path);
        });
        Ok(folder)
    }

    /// Removes damaged parts with points of the shard, and returns a sentence for each.
    fn remove_damaged(&self) -> Result<Vec<String>, FolderError> {
        let mut damaged = Vec::new();
        for part in parts::list(&self.dir)?.iter().filter(|part| self.shard.has_points_of(&part.points, self.plan.count())) {
            match self.plan.check(part) {
                Err(FolderError::Damaged { path, why }) => {
                    fs::remove_file(&path).map_err(write(&path))?;
                    damaged.push(format!("`{}` is damaged: it {why}", path.display()));
                }
                checked => drop(checked?),
            }
        }
        Ok(damaged)
    }

    /// Returns a sentence for each damaged part that was removed.
    pub fn damaged(&self) -> &[String] {
        &self.damaged
    }

    /// Returns the number of points of this shard that remain to be run.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn left(&self) -> Result<u64, FolderError> {
        Ok(self.missing()?.iter().map(|range| range.end - range.start).sum())
    }

    /// Returns the ranges of points of this shard that remain to be run.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn missing(&self) -> Result<Vec<std::ops::Range<u64>>, FolderError> {
        Ok(self.shard.missing(self.plan.count(), &parts::list(&self.dir)?))
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
        // Otherwise another process could open the file just before its removal, and lock it after.
        let _alone = locked(&self.dir);
        let _ = fs::remove_file(&self.lock);
    }
}

/// Returns a shard that a living process runs in a folder and that has points of this shard.
fn running(dir: &Path, shard: Shard, count: u64) -> Result<Option<Shard>, FolderError> {
    for entry in fs::read_dir(dir).map_err(read(dir))? {
        let path = entry.map_err(read(dir))?.path();
        let name = path.file_name().and_then(|name| name.to_str()?.strip_prefix(LOCK));
        let other = name.and_then(|name| name.replace(LOCK_OF, "/").parse().ok());
        if let Some(other) = other.filter(|&other| shard.overlaps(other, count) && is_alive(&path)) {
            return Ok(Some(other));
        }
    }
    Ok(None)
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

/// Writes a file atomically, also if the power fails.
fn put(path: &Path, bytes: &[u8]) -> Result<(), FolderError> {
    let unfinished = unfinished(path);
    let put = fs::write(&unfinished, bytes).and_then(|()| rename_synced(&unfinished, path));
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
mod tests;
