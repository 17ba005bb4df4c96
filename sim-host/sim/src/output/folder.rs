//! The folder of a run: it holds one run as a whole.
//!
//! A run is written into a folder of its own within it, and moved from there when it is whole; the manifest comes last and lists the files, so
//! that the next run removes exactly these. While files are moved the manifest says `complete: false` and lists those of both runs: whenever
//! that ends, the next run knows what to clean up. Files that no manifest lists are not of a run: they are neither removed nor written over. While a run is
//! being written into a folder, another one is refused.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use serde_json::{Value, json};

use super::OutputError;

/// The manifest, which says whose all other files are.
const MANIFEST: &str = "manifest.json";
/// Files of a run, beside its figures.
const NAMES: [&str; 8] =
    ["summary.json", "machine.json", "trace.csv", "trace.npy", "trace.parquet", "runs.csv", "grid.csv", "report.html"];
/// Files of a figure.
const FIGURE: [&str; 3] = ["svg", "png", "csv"];
/// How the folder of a run that is being written begins.
const UNFINISHED: &str = ".unfinished-";
/// Where a run goes that something is in the way of.
const BESIDE: &str = "run";

/// Tells apart what one process writes at a time.
static COUNT: AtomicU32 = AtomicU32::new(0);

/// A folder that a run is to go into.
pub struct Folder {
    dir: PathBuf,
    /// It was not there before.
    made: bool,
    /// Where the run is written until it is whole, which is locked as long as its process lives.
    unfinished: PathBuf,
    _living: Option<File>,
}

impl Folder {
    /// Makes the folder ready, before a run that may take long; refuses one with files of a run that has no manifest, or of another origin, and one into
    /// which another run is being written.
    pub fn open(dir: &Path) -> Result<Self, OutputError> {
        let made = !dir.exists();
        fs::create_dir_all(dir).map_err(write(dir))?;
        let own = format!("{UNFINISHED}{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let unfinished = dir.join(own);
        // No other process takes the new folder for one that was left.
        let _alone = locked(dir);
        former(dir)?;
        if let Some(process) = unfinished_runs(dir).find_map(|path| lives(&path).then(|| process_of(&path))) {
            return Err(OutputError::Held { path: dir.to_owned(), process });
        }
        fs::create_dir_all(&unfinished).map_err(write(&unfinished))?;
        let living = File::open(&unfinished).ok().filter(|folder| folder.try_lock().is_ok());
        Ok(Folder { dir: dir.to_owned(), made, unfinished, _living: living })
    }

    /// Where the run is to be written.
    pub fn unfinished(&self) -> &Path {
        &self.unfinished
    }

    /// Puts what was written in the place of the run before, and the manifest beside it.
    pub fn finish(&self, mut manifest: Value) -> Result<(), OutputError> {
        let files = plain_files(&self.unfinished)?;
        manifest["files"] = json!(files);
        let _alone = locked(&self.dir);
        remove_left(&self.dir);
        let former = former(&self.dir)?;
        if let Some(file) = files.iter().find(|&file| !former.contains(file) && self.dir.join(file).symlink_metadata().is_ok()) {
            self.put(&manifest)?;
            return Err(OutputError::InTheWay { path: self.dir.join(file), run: self.beside()? });
        }
        let both: BTreeSet<&String> = former.union(&files).collect();
        let mut moving = manifest.clone();
        (moving["complete"], moving["files"]) = (json!(false), json!(both));
        self.put(&moving)?;
        self.publish(MANIFEST)?;
        for file in former.difference(&files) {
            let path = self.dir.join(file);
            match fs::remove_file(&path) {
                Err(error) if error.kind() != ErrorKind::NotFound => return Err(write(&path)(error)),
                _ => {}
            }
        }
        files.iter().try_for_each(|file| self.publish(file))?;
        self.put(&manifest)?;
        self.publish(MANIFEST)
    }

    /// Writes a manifest where the run is written.
    fn put(&self, manifest: &Value) -> Result<(), OutputError> {
        let path = self.unfinished.join(MANIFEST);
        fs::write(&path, format!("{manifest:#}\n")).map_err(write(&path))
    }

    /// Moves a file into the folder.
    fn publish(&self, file: &str) -> Result<(), OutputError> {
        let path = self.dir.join(file);
        fs::rename(self.unfinished.join(file), &path).map_err(write(&path))
    }

    /// Moves the whole run into a folder of its own, and says where.
    fn beside(&self) -> Result<PathBuf, OutputError> {
        let free = (1_u32..).map(|n| self.dir.join(format!("{BESIDE}-{n}"))).find(|path| path.symlink_metadata().is_err());
        let path = free.unwrap_or_else(|| self.dir.join(BESIDE));
        fs::rename(&self.unfinished, &path).map_err(write(&path))?;
        Ok(path)
    }
}

impl Drop for Folder {
    /// What did not become whole is not left behind, nor a folder with nothing in it.
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.unfinished);
        if self.made {
            let _ = fs::remove_dir(&self.dir);
        }
    }
}

/// Keeps other runs from moving files in this folder, as long as it is held; where the system locks no folders, not.
fn locked(dir: &Path) -> Option<File> {
    File::open(dir).ok().filter(|folder| folder.lock().is_ok())
}

/// Removes what runs have left that were killed.
fn remove_left(dir: &Path) {
    for path in unfinished_runs(dir) {
        // Where the system locks no folders nobody knows who lives.
        if File::open(&path).is_ok_and(|folder| folder.try_lock().is_ok()) {
            let _ = fs::remove_dir_all(&path);
        }
    }
}

/// Where runs are being written, or were when they were killed.
fn unfinished_runs(dir: &Path) -> impl Iterator<Item = PathBuf> {
    let entries = fs::read_dir(dir).into_iter().flatten().flatten();
    entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(UNFINISHED)).map(|entry| entry.path())
}

/// Whether the process lives that writes this run: it holds the lock of its own folder.
fn lives(path: &Path) -> bool {
    File::open(path).is_ok_and(|folder| matches!(folder.try_lock(), Err(TryLockError::WouldBlock)))
}

/// The process that writes a run, by the name of its folder.
fn process_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.trim_start_matches(UNFINISHED).split('-').next().unwrap_or_default().to_owned()
}

/// The files of the run that a folder holds, without its manifest.
fn former(dir: &Path) -> Result<BTreeSet<String>, OutputError> {
    let path = dir.join(MANIFEST);
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let whose = NAMES.iter().map(|name| dir.join(name)).find(|path| path.symlink_metadata().is_ok());
            return whose.map_or_else(|| Ok(BTreeSet::new()), |path| Err(OutputError::Strange { path }));
        }
        Err(_) => return Err(OutputError::Strange { path }),
    };
    let manifest: Value = serde_json::from_str(&text).unwrap_or_default();
    if manifest["program"] != "sim-host" {
        return Err(OutputError::Strange { path });
    }
    match &manifest["files"] {
        Value::Null => Ok(unlisted(plain_files(dir)?)),
        // A name that leads out of the folder is none of a run's.
        files => Ok(files
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_str)
            .filter(|name| is_plain(name))
            .map(Into::into)
            .collect()),
    }
}

/// Of these files those of a run, by their names: the manifests of version 0.1.0 do not list them.
fn unlisted(files: BTreeSet<String>) -> BTreeSet<String> {
    let of_a_figure = |file: &str| {
        let (id, extension) = file.rsplit_once('.').unwrap_or_default();
        FIGURE.contains(&extension) && FIGURE.iter().all(|other| files.contains(&format!("{id}.{other}")))
    };
    files.iter().filter(|file| NAMES.contains(&file.as_str()) || of_a_figure(file)).cloned().collect()
}

/// The files of a folder, by their names, without the manifest.
fn plain_files(dir: &Path) -> Result<BTreeSet<String>, OutputError> {
    let mut names = BTreeSet::new();
    for entry in fs::read_dir(dir).map_err(write(dir))? {
        let entry = entry.map_err(write(dir))?;
        let is_file = entry.file_type().map_err(write(dir))?.is_file();
        names.extend(entry.file_name().into_string().ok().filter(|name| is_file && name != MANIFEST));
    }
    Ok(names)
}

/// Whether this is a file's name, and no path.
fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(Component::Normal(part)), None) if part == name) && name != MANIFEST
}

fn write(path: &Path) -> impl FnOnce(std::io::Error) -> OutputError + use<> {
    let path = path.to_owned();
    |io| OutputError::Write { path, io }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_name_within_the_folder_is_one_of_its_files() {
        assert!(["trace.csv", "a-b_1.svg", "..."].iter().all(|name| is_plain(name)));
        assert!(["", ".", "..", "/etc/passwd", "../trace.csv", "a/b", "a/", "manifest.json"].iter().all(|name| !is_plain(name)));
    }

    #[test]
    fn without_a_list_a_figure_is_known_by_its_three_files() {
        let names = ["trace.csv", "f.svg", "f.png", "f.csv", "notes.txt", "own.csv", "half.png", "half.svg"];
        let found = unlisted(names.iter().map(|&name| name.into()).collect());
        assert_eq!(found.iter().map(String::as_str).collect::<Vec<_>>(), ["f.csv", "f.png", "f.svg", "trace.csv"]);
    }
}
