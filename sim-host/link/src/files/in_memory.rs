//! Files in memory: a program without a disk gives those that commands read, and takes those that
//! they write.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use report::{Figure, Report};

use crate::link_error::LinkError;

thread_local! {
    static WRITTEN: RefCell<Vec<(String, String)>> = const { RefCell::new(Vec::new()) };
    static DRAWN: RefCell<Vec<Figure>> = const { RefCell::new(Vec::new()) };
    static GIVEN: RefCell<Option<(PathBuf, Vec<u8>)>> = const { RefCell::new(None) };
}

/// Takes the names and texts of all files that commands have written since the last call.
pub fn take() -> Vec<(String, String)> {
    WRITTEN.take()
}

/// Takes the figures of all results that commands have written since the last call.
pub fn take_figures() -> Vec<Figure> {
    DRAWN.take()
}

/// Gives commands a file to read, instead of an earlier one.
pub fn put(path: PathBuf, bytes: Vec<u8>) {
    GIVEN.set(Some((path, bytes)));
}

/// Reads the file that was given.
pub fn read(path: &Path, max_bytes: u64) -> Result<Vec<u8>, LinkError> {
    let refused = |why: &str| LinkError::Input(format!("{} cannot be read: {why}", path.display()));
    GIVEN.with_borrow(|given| match given {
        Some((name, bytes)) if name == path && bytes.len() as u64 <= max_bytes => Ok(bytes.clone()),
        Some((name, _)) if name == path => Err(refused("it is too long")),
        _ => Err(refused("it was not opened in this page")),
    })
}

/// Folder in memory. It contains figures and their data, but no pictures.
pub struct ResultFolder {
    dir: PathBuf,
    files: RefCell<Vec<(String, String)>>,
    figures: RefCell<Vec<Figure>>,
}

impl ResultFolder {
    /// Opens the folder of a command.
    pub fn open(_command: &str, dir: &Path, _inputs: &[PathBuf]) -> Result<Self, LinkError> {
        Ok(ResultFolder { dir: dir.to_owned(), files: RefCell::default(), figures: RefCell::default() })
    }

    /// Writes a text.
    pub fn file(&self, name: &str, text: &str) -> Result<(), LinkError> {
        let path = self.dir.join(name).to_string_lossy().into_owned();
        self.files.borrow_mut().push((path, text.to_owned()));
        Ok(())
    }

    /// Keeps a report's figures, and writes their data.
    pub fn report(&self, report: &Report) -> Result<(), LinkError> {
        self.figures.borrow_mut().extend(report.figures.iter().cloned());
        report.figures.iter().try_for_each(|figure| self.file(&format!("{}.csv", figure.id), &report::csv(figure)?))
    }

    /// Puts the complete result into its place.
    pub fn finish(self) -> Result<(), LinkError> {
        WRITTEN.with_borrow_mut(|files| files.extend(self.files.take()));
        DRAWN.with_borrow_mut(|figures| figures.extend(self.figures.take()));
        Ok(())
    }
}
