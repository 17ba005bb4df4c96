//! Folder of a result, which contains one complete result.
//!
//! A result is written into a temporary subfolder, and moved from there when it is complete. The
//! manifest comes last. It names the command and lists the files with their checksums. The same
//! command replaces exactly these files, and only if none of them has changed and none is one of
//! its inputs. Otherwise the folder remains unchanged. While files are moved, the manifest has
//! `complete: false` and lists the files of both results: the next run cleans up after any
//! interruption. While a result is being written into a folder, another one is refused.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use serde_json::{Value, json};

use super::OutputError;
use super::sweep::{PLAN, SWEEP};
use columns::{file, visible_line};
use scene::load::is_unchanged;

/// Manifest, which names the command of all other files.
const MANIFEST: &str = "manifest.json";
/// Files that identify a folder without a manifest as a result.
const NAMES: [&str; 10] = [
    "summary.json",
    "machine.json",
    "trace.csv",
    "trace.npy",
    "trace.parquet",
    "runs.csv",
    "grid.csv",
    "report.html",
    "stack.toml",
    PLAN,
];
/// Prefix of the folder of a run that is being written.
const UNFINISHED: &str = ".unfinished-";
/// Prefix of the subfolder for a run whose files may not replace others.
const ASIDE: &str = "run";
/// Reason for keeping a file that no manifest lists.
const UNLISTED: &str = "is not listed in the manifest of an earlier result";
/// Reason for keeping a file that its user has edited.
const CHANGED: &str = "was changed after it was written";

/// Number that distinguishes simultaneous outputs of one process.
static COUNT: AtomicU32 = AtomicU32::new(0);

/// A command that writes a folder, and its inputs, which it never replaces.
#[derive(Clone, Debug)]
pub struct Owner {
    command: String,
    inputs: Vec<PathBuf>,
}

impl Owner {
    /// Creates the owner from the name of the command and the files or folders that it reads;
    /// missing ones are ignored.
    pub fn new(command: &str, inputs: impl IntoIterator<Item = impl AsRef<Path>>) -> Self {
        let inputs = inputs.into_iter().filter_map(|path| path.as_ref().canonicalize().ok()).collect();
        Owner { command: command.to_owned(), inputs }
    }
}

/// Returns the folder of a result within `out`. A name that is not a plain file name on every
/// system is replaced, because it could lead elsewhere.
pub fn default_dir(name: &str) -> PathBuf {
    Path::new("out").join(if is_plain(name) && is_portable(name) { name } else { "unnamed" })
}

/// Returns `true` if a file can have this name on every system
/// (<https://learn.microsoft.com/windows/win32/fileio/naming-a-file>).
fn is_portable(name: &str) -> bool {
    const DEVICES: [&str; 4] = ["CON", "PRN", "AUX", "NUL"];
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_uppercase();
    let port = stem.strip_prefix("COM").or(stem.strip_prefix("LPT")).is_some_and(|port| port.chars().count() == 1);
    let is_device = DEVICES.contains(&stem.as_str()) || port;
    visible_line(name) == name
        && !name.contains(['<', '>', ':', '"', '/', '\\', '|', '?', '*'])
        && !name.ends_with(['.', ' '])
        && !is_device
}

/// Folder for a result.
pub struct Folder {
    dir: PathBuf,
    owner: Owner,
    /// File that rules out the preferred folder, with the reason.
    avoided: Option<String>,
    /// `true` if the folder did not exist before.
    made: bool,
    /// Temporary folder of the run until it is complete; locked while its process is alive.
    unfinished: PathBuf,
    _living: Option<File>,
}

impl Folder {
    /// Opens the folder of a name within `out`, or the next free one (`out/NAME-COMMAND`) if the
    /// command may not replace its contents.
    pub fn open_default(name: &str, owner: &Owner) -> Result<Self, OutputError> {
        let dir = default_dir(name);
        let command = owner.command.rsplit(' ').next().unwrap_or_default();
        let (mut avoided, mut ending, mut number) = (None, String::new(), 1);
        loop {
            match Self::open(Path::new(&format!("{}{ending}", dir.display())), owner.clone()) {
                Err(OutputError::Taken { path, why }) => {
                    avoided = avoided.or_else(|| Some(format!("`{}` {why}", path.display())))
                }
                opened => {
                    let mut folder = opened?;
                    folder.avoided = avoided;
                    return Ok(folder);
                }
            }
            ending = if number == 1 { format!("-{command}") } else { format!("-{command}-{number}") };
            number += 1;
        }
    }

    /// Prepares the folder before a run that may take long. Refuses a folder with files that the
    /// command may not replace, and one into which another result is being written.
    pub fn open(dir: &Path, owner: Owner) -> Result<Self, OutputError> {
        let made = !dir.exists();
        fs::create_dir_all(dir).map_err(write(dir))?;
        let own = format!("{UNFINISHED}{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let unfinished = dir.join(own);
        // The lock keeps other processes from removing the new folder as a leftover.
        let _alone = locked(dir);
        replaceable(dir, &owner)?;
        if let Some(process) = unfinished_runs(dir).find_map(|path| is_alive(&path).then(|| process_of(&path))) {
            return Err(OutputError::Held { path: dir.to_owned(), process });
        }
        fs::create_dir_all(&unfinished).map_err(write(&unfinished))?;
        let living = File::open(&unfinished).ok().filter(|folder| folder.try_lock().is_ok());
        Ok(Folder { dir: dir.to_owned(), owner, avoided: None, made, unfinished, _living: living })
    }

    /// Returns the folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Returns the reason for not using the preferred folder, if it is not used.
    pub fn avoided(&self) -> Option<&str> {
        self.avoided.as_deref()
    }

    /// Returns the temporary folder into which the run must be written.
    pub fn unfinished(&self) -> &Path {
        &self.unfinished
    }

    /// Replaces the previous result with the new one, and adds program, command, files and
    /// checksums to its manifest.
    pub fn finish(&self, mut manifest: Value) -> Result<(), OutputError> {
        let files = plain_files(&self.unfinished)?;
        let sum = |name: &String| {
            let path = self.unfinished.join(name);
            let sum = synced(&path).and_then(|()| File::open(&path)).and_then(checksum);
            Ok((name.clone(), sum.map_err(write(&path))?))
        };
        let sums = files.iter().map(sum).collect::<Result<BTreeMap<_, _>, OutputError>>()?;
        (manifest["program"], manifest["version"]) = (json!("sim-host"), json!(crate::VERSION));
        (manifest["command"], manifest["files"], manifest["checksums"]) = (json!(self.owner.command), json!(files), json!(sums));
        let _alone = locked(&self.dir);
        remove_leftovers(&self.dir);
        let foreign = |former: &BTreeMap<String, String>| {
            let in_the_way = |file: &&String| !former.contains_key(*file) && self.dir.join(file).symlink_metadata().is_ok();
            files.iter().find(in_the_way).map(|file| self.dir.join(file))
        };
        let former = replaceable(&self.dir, &self.owner).and_then(|former| match foreign(&former) {
            Some(path) => Err(OutputError::Taken { path, why: UNLISTED.to_owned() }),
            None => Ok(former),
        });
        let former = match former {
            Err(OutputError::Taken { path, why }) => {
                self.put(&manifest)?;
                return Err(OutputError::InTheWay { path, why, run: self.move_aside()? });
            }
            former => former?,
        };
        let mut moving = manifest.clone();
        let both: BTreeSet<&String> = former.keys().chain(&files).collect();
        (moving["complete"], moving["files"], moving["former"]) = (json!(false), json!(both), json!(former));
        self.put(&moving)?;
        self.publish_manifest()?;
        for file in former.keys().filter(|&file| !files.contains(file)) {
            let path = self.dir.join(file);
            match fs::remove_file(&path) {
                Err(error) if error.kind() != ErrorKind::NotFound => return Err(write(&path)(error)),
                _ => {}
            }
        }
        for file in &files {
            let path = self.dir.join(file);
            fs::rename(self.unfinished.join(file), &path).map_err(write(&path))?;
        }
        sync_folder(&self.dir);
        self.put(&manifest)?;
        self.publish_manifest()
    }

    /// Writes a manifest into the temporary folder. Its own checksum is computed with an empty one
    /// in its text.
    fn put(&self, manifest: &Value) -> Result<(), OutputError> {
        let path = self.unfinished.join(MANIFEST);
        let mut manifest = manifest.clone();
        manifest["checksums"][MANIFEST] = json!("");
        let text = format!("{manifest:#}\n");
        let entry = |sum: &str| format!("\"{MANIFEST}\": \"{sum}\"");
        let sealed = checksum(text.as_bytes()).map(|sum| text.replacen(&entry(""), &entry(&sum), 1));
        sealed.and_then(|text| fs::write(&path, text)).map_err(write(&path))
    }

    /// Moves the manifest into the folder.
    fn publish_manifest(&self) -> Result<(), OutputError> {
        let path = self.dir.join(MANIFEST);
        rename_synced(&self.unfinished.join(MANIFEST), &path).map_err(write(&path))
    }

    /// Moves the complete run into a separate subfolder, and returns its path.
    fn move_aside(&self) -> Result<PathBuf, OutputError> {
        let free = (1_u32..).map(|n| self.dir.join(format!("{ASIDE}-{n}"))).find(|path| path.symlink_metadata().is_err());
        let path = free.unwrap_or_else(|| self.dir.join(ASIDE));
        fs::rename(&self.unfinished, &path).map_err(write(&path))?;
        sync_folder(&self.dir);
        Ok(path)
    }
}

impl Drop for Folder {
    /// Removes an incomplete result, and the folder if it was created and is empty.
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.unfinished);
        if self.made {
            let _ = fs::remove_dir(&self.dir);
        }
    }
}

/// Renames a complete file. After a power failure the new name refers to all of its content, or
/// does not exist.
pub fn rename_synced(from: &Path, to: &Path) -> io::Result<()> {
    synced(from)?;
    fs::rename(from, to)?;
    if let Some(dir) = to.parent() {
        sync_folder(dir);
    }
    Ok(())
}

/// Waits until the content of a file is on the disk. Some systems require the right to write.
fn synced(path: &Path) -> io::Result<()> {
    File::options().write(true).open(path)?.sync_all()
}

/// Waits until the names in a folder (`""`: the current one) are on the disk, if the system can.
fn sync_folder(dir: &Path) {
    let _ = File::open(Path::new(".").join(dir)).and_then(|dir| dir.sync_all());
}

/// Keeps other processes from moving files and taking locks in this folder while the lock is held;
/// `None` if the system cannot lock folders.
pub(super) fn locked(dir: &Path) -> Option<File> {
    File::open(dir).ok().filter(|folder| folder.lock().is_ok())
}

/// Removes leftovers of killed runs.
fn remove_leftovers(dir: &Path) {
    for path in unfinished_runs(dir) {
        // If the system cannot lock folders, leftovers cannot be identified and remain.
        if File::open(&path).is_ok_and(|folder| folder.try_lock().is_ok()) {
            let _ = fs::remove_dir_all(&path);
        }
    }
}

/// Returns the temporary folders of runs in progress and of killed runs.
fn unfinished_runs(dir: &Path) -> impl Iterator<Item = PathBuf> {
    let entries = fs::read_dir(dir).into_iter().flatten().flatten();
    // The name of a temporary folder: process and number.
    let is_ours = |name: &str| {
        let numbers = name.strip_prefix(UNFINISHED).and_then(|rest| rest.split_once('-'));
        numbers.is_some_and(|(process, number)| [process, number].iter().all(|text| text.parse::<u64>().is_ok()))
    };
    entries.filter(move |entry| is_ours(&entry.file_name().to_string_lossy())).map(|entry| entry.path())
}

/// Returns `true` if the process that locked this file or folder is alive.
pub(super) fn is_alive(path: &Path) -> bool {
    File::open(path).is_ok_and(|folder| matches!(folder.try_lock(), Err(TryLockError::WouldBlock)))
}

/// Returns the process that writes a run, from the name of its folder.
fn process_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.trim_start_matches(UNFINISHED).split('-').next().unwrap_or_default().to_owned()
}

/// Returns the files and checksums of the result in a folder, without its manifest; refuses a
/// folder that the command may not change.
pub(super) fn replaceable(dir: &Path, owner: &Owner) -> Result<BTreeMap<String, String>, OutputError> {
    let taken = |path: PathBuf, why: &str| Err(OutputError::Taken { path, why: why.to_owned() });
    let path = dir.join(MANIFEST);
    let text = match file::read(&path, file::MAX_DATA_BYTES) {
        Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            // A sweep continues from its plan.
            let names = NAMES.iter().filter(|&&name| name != PLAN || owner.command != SWEEP);
            let whose = names.map(|name| dir.join(name)).find(|path| path.symlink_metadata().is_ok());
            return whose.map_or_else(|| Ok(BTreeMap::new()), |path| taken(path, UNLISTED));
        }
        Err(_) => return taken(path, UNLISTED),
    };
    let manifest: Value = serde_json::from_str(&text).unwrap_or_default();
    match (manifest["command"].as_str(), manifest["checksums"].as_object()) {
        _ if manifest["program"] != "sim-host" => return taken(path, "is not a manifest of sim-host"),
        (Some(command), Some(_)) if command == owner.command => {}
        (Some(command), Some(_)) => return taken(path, &format!("belongs to the command `{command}`")),
        _ => return taken(path, "was written by an older version, without checksums"),
    }
    let known = |name: &str| [&manifest["checksums"][name], &manifest["former"][name]];
    if is_unchanged(&text, &manifest) != Some(true) {
        return taken(path, CHANGED);
    }
    let listed = manifest["files"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let mut files = BTreeMap::new();
    // A name that leads out of the folder is not a file of a run.
    for name in listed.filter(|name| is_plain(name)).chain([MANIFEST]) {
        let path = dir.join(name);
        let is_input = |path: &PathBuf| owner.inputs.iter().any(|input| path == input || path.parent() == Some(input));
        if path.canonicalize().is_ok_and(|path| is_input(&path)) {
            return taken(path, "is an input of this command");
        }
        match File::open(&path).and_then(checksum) {
            _ if name == MANIFEST => {}
            Ok(sum) if known(name).iter().any(|known| **known == sum) => drop(files.insert(name.to_owned(), sum)),
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            _ => return taken(path, CHANGED),
        }
    }
    Ok(files)
}

/// Returns the CRC-64/XZ of all data read, as 16 hexadecimal digits.
pub(crate) fn checksum(mut from: impl Read) -> io::Result<String> {
    static TABLE: crc::Crc<u64, crc::Table<16>> = crc::Crc::<u64, crc::Table<16>>::new(&crc::CRC_64_XZ);
    let (mut digest, mut buffer) = (TABLE.digest(), vec![0; 1 << 16]);
    loop {
        match from.read(&mut buffer)? {
            0 => return Ok(format!("{:016x}", digest.finalize())),
            count => digest.update(&buffer[..count]),
        }
    }
}

/// Returns the names of the files in a folder, without the manifest.
fn plain_files(dir: &Path) -> Result<BTreeSet<String>, OutputError> {
    let mut names = BTreeSet::new();
    for entry in fs::read_dir(dir).map_err(write(dir))? {
        let entry = entry.map_err(write(dir))?;
        let is_file = entry.file_type().map_err(write(dir))?.is_file();
        names.extend(entry.file_name().into_string().ok().filter(|name| is_file && name != MANIFEST));
    }
    Ok(names)
}

/// Returns `true` if this is a file name and not a path.
fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(Component::Normal(part)), None) if part == name) && name != MANIFEST
}

fn write(path: &Path) -> impl FnOnce(io::Error) -> OutputError + use<> {
    let path = path.to_owned();
    |io| OutputError::Write { path, io }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_not_accepted_as_file_names() {
        assert!(["trace.csv", "a-b_1.svg", "..."].iter().all(|name| is_plain(name)));
        for name in ["...", "..", "a/b", "a\\b", "a\u{1b}[2J", "a\u{202e}b", "nul", "Com1.scene", "c:d", "a ", ""] {
            assert_eq!(default_dir(name), Path::new("out/unnamed"), "{name:?}");
        }
        assert_eq!(default_dir("köln 1.5 comma"), Path::new("out/köln 1.5 comma"));
        assert!(["", ".", "..", "/etc/passwd", "../trace.csv", "a/b", "a/", "manifest.json"].iter().all(|name| !is_plain(name)));
    }
}
