//! Flash of a simulated board in a file, so that the board keeps its settings between runs as a
//! real one keeps them over power-off.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use delimited::file::MAX_DATA_BYTES;
use hal_mock::bench::Setup;
use hal_mock::flash::Flash;
use link::link_error::LinkError;
use sim::output::rename_synced;

/// Reads the flash from a file; `None` if the file does not exist yet.
pub(super) fn read(file: &Path) -> Result<Option<Flash>, LinkError> {
    let fresh = Setup::default().flash;
    let refused = |why: String| LinkError::Input(format!("the flash file `{}` {why}", file.display()));
    match delimited::file::read(file, MAX_DATA_BYTES) {
        Ok(bytes) if bytes.len() == fresh.bytes().len() => Ok(Some(Flash::holding(bytes, 1))),
        Ok(bytes) => {
            Err(refused(format!("has {} bytes, but the flash of a simulated board has {}", bytes.len(), fresh.bytes().len())))
        }
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(refused(format!("cannot be read: {error}"))),
    }
}

/// Writes the flash to its file, completely or not at all.
pub(super) fn write(file: &Path, flash: &Flash) -> Result<(), LinkError> {
    let mut unfinished = file.as_os_str().to_owned();
    unfinished.push(".unfinished");
    let written = fs::write(&unfinished, flash.bytes()).and_then(|()| rename_synced(unfinished.as_ref(), file));
    written.map_err(|error| LinkError::Failed(format!("the flash file `{}` cannot be written: {error}", file.display())))
}
