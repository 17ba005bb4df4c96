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
use super::folder::{Owner, is_alive, locked, rename_synced, replaceable};
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
    /// Another process runs points of the same shard.
    #[error("another process runs shard {running} of the sweep in `{}`, which has points of this shard ({shard}): wait until it \
             ends", path.display())]
    Held {
        /// Folder.
        path: PathBuf,
        /// Shard that is running.
        running: Shard,
        /// Shard that is refused.
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
    /// The bytes of a part have changed.
    #[error("`{}` is damaged: it {why}; the `sweep` command that wrote it computes its points again", path.display())]
    Damaged {
        /// File of the part.
        path: PathBuf,
        /// Evidence, as a predicate.
        why: &'static str,
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
mod tests {
    use super::*;
    use crate::output::Presentation;
    use crate::study::sweep::design::Design;
    use scene::load::load;

    fn with_sweep(name: &str, points: &str, test: impl FnOnce(&Path, &Sweep)) {
        let dir = std::env::temp_dir().join(format!("{name}-{}", std::process::id()));
        let loaded = load("contact-kinematic", &[]).expect("a scene");
        let axis = format!("contact.dahl.mu={points}").parse().expect("an axis");
        let design = Design::product(vec![axis]).expect("a design");
        test(&dir, &Sweep::new(&loaded, design, &["friction_ratio".to_owned()]).expect("a sweep"));
        fs::remove_dir_all(&dir).expect("removed");
    }

    fn open(dir: &Path, sweep: &Sweep, shard: &str) -> Result<SweepFolder, FolderError> {
        SweepFolder::open(dir, sweep, shard.parse().expect("a shard"), &[])
    }

    /// A change of any bit is detected before the file is parsed. A resumed sweep replaces damaged
    /// parts, and its result is identical.
    #[test]
    fn damaged_parts_are_detected_and_replaced() {
        with_sweep("damaged", "0.1,0.2,0.3", |dir, sweep| {
            let result = || {
                let joined = join(&[dir.to_owned()], dir, &Presentation::default());
                joined.map(|_| [TABLE, ROWS, PAGE].map(|name| fs::read(dir.join(name)).expect("a file")))
            };
            let run = || {
                let folder = open(dir, sweep, "1/1").expect("a folder");
                assert!(folder.run(sweep, &AtomicBool::new(false), &|| ()).expect("all points"));
                folder.damaged().join(", ")
            };
            assert_eq!(run(), "");
            let sound = result().expect("a result");
            let plan = PlanFile::new(sweep);
            let part = parts::list(dir).expect("a folder").remove(0);
            let bytes = fs::read(&part.path).expect("a part");
            let mut flipped = bytes.clone();
            for bit in (0..8 * bytes.len()).step_by(7) {
                flipped[bit / 8] ^= 1 << (bit % 8);
                fs::write(&part.path, &flipped).expect("written");
                assert!(matches!(plan.check(&part), Err(FolderError::Damaged { .. })), "bit {bit}");
                flipped[bit / 8] = bytes[bit / 8];
            }
            flipped[100] ^= 1;
            let tail = bytes[..bytes.len() - 1].to_vec();
            for damaged in [flipped, vec![0; bytes.len()], Vec::new(), tail, bytes[..8].to_vec(), b"PAR1PAR1".to_vec()] {
                fs::write(&part.path, &damaged).expect("written");
                assert!(result().is_err_and(|error| matches!(error, FolderError::Damaged { .. })));
                assert!(run().contains("does not match the checksum in its name"));
                assert!(fs::read(&part.path).expect("a part") == bytes);
            }
            // A sound part without a checksum in its name.
            fs::rename(&part.path, Part::new(dir, part.points.clone(), None).path).expect("renamed");
            assert!(result().is_err() && run().contains("has no checksum in its name"));
            assert!(result().expect("a result") == sound && parts::list(dir).expect("a folder") == [part]);
        });
    }

    /// The points in a part must be those in its name.
    #[test]
    fn part_with_other_points_is_refused() {
        with_sweep("other-points", "0.1,0.2,0.3,0.4", |dir, sweep| {
            let plan = open(dir, sweep, "1/1").expect("a folder").plan.clone();
            let part = plan.write_part(sweep, 0..2, dir, (&AtomicBool::new(false), &|| ())).expect("written").expect("a part");
            let sum = part.path.file_stem().and_then(|name| Some(name.to_str()?.rsplit('-').next()?.to_owned()));
            fs::copy(&part.path, Part::new(dir, 2..4, sum).path).expect("copied");
            let refused = join(&[dir.to_owned()], dir, &Presentation::default());
            assert!(matches!(&refused, Err(FolderError::Part { path }) if *path != part.path), "{refused:?}");
        });
    }

    /// Shards with a common point are refused while one of them runs, all others are accepted.
    #[test]
    fn overlapping_shards_are_refused_while_one_runs() {
        with_sweep("overlap", "0.1:0.5:40", |dir, sweep| {
            let shards = ["1/1", "1/2", "2/2", "1/3", "3/3", "1/4", "2/4", "4/4", "40/40"];
            let points = |shard: &str| -> Vec<u64> {
                let shard: Shard = shard.parse().expect("a shard");
                shard.missing(40, &[]).into_iter().flatten().collect()
            };
            for running in shards {
                let held = open(dir, sweep, running).expect("a free folder");
                for other in shards {
                    let overlap = points(running).iter().any(|point| points(other).contains(point));
                    match open(dir, sweep, other) {
                        Ok(_) => assert!(!overlap, "{running}, {other}"),
                        Err(error) => {
                            let says = format!("another process runs shard {running} of the sweep");
                            assert!(overlap && error.to_string().contains(&says), "{running}, {other}: {error}");
                        }
                    }
                }
                drop(held);
            }
            assert_eq!(running(dir, Shard::WHOLE, 40).expect("a folder"), None);
        });
    }

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
