//! Errors of the folder of a sweep.

use std::io;
use std::path::PathBuf;

use report::ReportError;

use super::{PLAN, Shard};
use crate::output::OutputError;
use crate::study::StudyError;

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
