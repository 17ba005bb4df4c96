//! Files on the disk.

use std::path::{Path, PathBuf};

use columns::file;
use report::Report;
use serde_json::json;
use sim::output::{Folder, Owner};

use crate::link_error::LinkError;

/// Reads an image, an update or another input of at most `max_bytes`.
pub fn read(path: &Path, max_bytes: u64) -> Result<Vec<u8>, LinkError> {
    file::read(path, max_bytes).map_err(|error| LinkError::Input(format!("{} cannot be read: {error}", path.display())))
}

/// Folder that appears on the disk when it is complete.
pub struct ResultFolder {
    folder: Folder,
    dir: PathBuf,
}

impl ResultFolder {
    /// Opens the folder of a command, which replaces none of the `inputs`.
    pub fn open(command: &str, dir: &Path, inputs: &[PathBuf]) -> Result<Self, LinkError> {
        let folder = Folder::open(dir, Owner::new(&format!("link {command}"), inputs))?;
        Ok(ResultFolder { folder, dir: dir.to_owned() })
    }

    /// Writes a text.
    pub fn file(&self, name: &str, text: &str) -> Result<(), LinkError> {
        let path = self.dir.join(name);
        std::fs::write(self.folder.unfinished().join(name), text).map_err(|io| LinkError::Write { path, io })
    }

    /// Writes a report with the pictures and data of its figures.
    pub fn report(&self, report: &Report) -> Result<(), LinkError> {
        Ok(report::write(report, self.folder.unfinished())?)
    }

    /// Puts the complete result into its place.
    pub fn finish(self) -> Result<(), LinkError> {
        Ok(self.folder.finish(json!({ "complete": true, "level": "board", "version": env!("CARGO_PKG_VERSION") }))?)
    }
}
