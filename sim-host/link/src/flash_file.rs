//! Flash of a simulated board in a file, so that the board keeps its settings between runs as a
//! real one keeps them over power-off.
//!
//! Each operation on the flash is in the file before the board answers. If the file cannot be
//! written, the operation fails, and the board reports that nothing is stored. After the first
//! operation a second file, `FILE.stored`, shows that the board was in use: if only that one is
//! left, a limit may be lost, and the board is not replaced by a new one.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use columns::file as bounded;
use hal_mock::bench::Setup;
use hal_mock::flash::{Flash, Mirror, PAGE_BYTES};
use sim::output::rename_synced;

use crate::link_error::LinkError;

/// Content of the file that shows that a flash file was in use.
const STORED_NOTE: &str = "The flash file of a simulated board was in use here. Without it, delete this file for a new board.\n";

/// File of a flash.
#[derive(Debug)]
pub struct FlashFile {
    path: PathBuf,
    /// Called with the cause of a failure, when it begins.
    note: fn(&str),
    /// Cause of the last failure, unless a write has succeeded since.
    failure: Mutex<Option<String>>,
}

impl FlashFile {
    /// Reads the flash from a file, or creates an empty one. The file follows each later change of
    /// the flash.
    pub fn open(path: &Path, note: fn(&str)) -> Result<(Flash, Arc<Self>), LinkError> {
        let file = Arc::new(FlashFile { path: path.to_owned(), note, failure: Mutex::new(None) });
        let fresh = Setup::default().flash;
        let size = fresh.bytes().len();
        let refused = |why: String| LinkError::Input(format!("the flash file `{}` {why}", path.display()));
        let flash = match bounded::read(path, bounded::MAX_DATA_BYTES) {
            Ok(bytes) if bytes.len() == size => Flash::holding(bytes, 1),
            // Earlier versions had no page for the marker of stored settings.
            Ok(bytes) if bytes.len() + PAGE_BYTES == size => Flash::holding([vec![0xFF; PAGE_BYTES], bytes].concat(), 1),
            Ok(bytes) => {
                return Err(refused(format!("has {} bytes, but the flash of a simulated board has {size}", bytes.len())));
            }
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(refused(format!("cannot be read: {error}"))),
            Err(_) if file.beside(".stored").exists() => {
                return Err(refused(format!(
                    "is missing, but `{0}` shows that it was in use and may have had lower limits: restore it, or delete `{0}` \
                     to begin with a new board",
                    file.beside(".stored").display()
                )));
            }
            Err(_) => {
                file.write(fresh.bytes()).map_err(|error| refused(format!("cannot be written: {error}")))?;
                fresh
            }
        };
        Ok((flash.with_mirror(file.clone()), file))
    }

    /// Returns an error if the file does not contain the last change of the flash.
    pub fn check(&self) -> Result<(), LinkError> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone().map_or(Ok(()), |why| Err(LinkError::Failed(why)))
    }

    /// Returns the path of another file that belongs to this one.
    fn beside(&self, ending: &str) -> PathBuf {
        let mut path = self.path.as_os_str().to_owned();
        path.push(ending);
        path.into()
    }

    /// Writes the file, completely or not at all.
    fn write(&self, bytes: &[u8]) -> io::Result<()> {
        let unfinished = self.beside(".unfinished");
        fs::write(&unfinished, bytes).and_then(|()| rename_synced(&unfinished, &self.path)).inspect_err(|_| {
            let _ = fs::remove_file(&unfinished);
        })
    }
}

impl Mirror for FlashFile {
    fn keep(&self, bytes: &[u8]) -> bool {
        let stored = self.beside(".stored");
        let kept = self.write(bytes).and_then(|()| if stored.exists() { Ok(()) } else { fs::write(stored, STORED_NOTE) });
        let why = kept.err().map(|error| {
            let file = self.path.display();
            format!(
                "the flash file `{file}` cannot be written: {error}. The settings act until this program ends, but are NOT \
                 stored; free the space or the path, then `settings store` again"
            )
        });
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        why.iter().filter(|_| failure.is_none()).for_each(|why| (self.note)(why));
        *failure = why;
        failure.is_none()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;
    use std::sync::atomic::AtomicBool;

    use firmware::board::settings::Settings;
    use firmware::board::stored_state::StoredState;

    use super::*;
    use crate::client::Client;
    use crate::commands::settings::{self, SettingsOrder};
    use crate::port::Simulated;
    use crate::session::{Session, SessionOptions};
    use crate::simulated_board::SimulatedBoard;

    /// Calls `act` with a session at a board with its flash in this file.
    fn at_board<T>(path: &Path, act: impl FnOnce(&mut Session) -> T) -> T {
        static NEVER: AtomicBool = AtomicBool::new(false);
        let (flash, file) = FlashFile::open(path, |_| ()).unwrap();
        let loaded = scene::load::load("lock", &[]).unwrap();
        let board = SimulatedBoard::with_flash(&loaded.scene.driven().unwrap(), 0, flash).unwrap();
        let board = Rc::new(RefCell::new(board));
        let client = Client::new(Box::new(Simulated::new("sim", board, false)), &NEVER, |_| ());
        let mut session = Session::begin(client, SessionOptions::default()).unwrap();
        let done = act(&mut session);
        // The process is killed.
        std::mem::forget((session, file));
        done
    }

    fn set_and_store(session: &mut Session, volts: &str) -> Result<(), LinkError> {
        let set = SettingsOrder::Set { name: "limits.voltage_v".into(), value: volts.into() };
        settings::run(&set, session).and_then(|_| settings::run(&SettingsOrder::Store, session)).map(drop)
    }

    fn stored(path: &Path) -> (usize, StoredState) {
        let (flash, _) = FlashFile::open(path, |_| ()).unwrap();
        let (record, state) = Settings::new(flash).unwrap().record();
        (record.parameters.len(), state)
    }

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("sonoglide-flash-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn stored_settings_are_in_the_file_when_the_board_answers() {
        let folder = folder("store");
        let path = folder.join("board.flash");
        at_board(&path, |session| {
            set_and_store(session, "3.5").unwrap();
            assert_eq!(stored(&path), (1, StoredState::Stored));
            settings::run(&SettingsOrder::Clear, session).unwrap();
            assert_eq!(stored(&path), (0, StoredState::Nothing));
            set_and_store(session, "4.5").unwrap();
        });
        assert_eq!(stored(&path), (1, StoredState::Stored));
        // A file of an earlier version has no page for the marker.
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[PAGE_BYTES..]).unwrap();
        assert_eq!(stored(&path), (1, StoredState::Stored));
        // An erased board differs from a new one.
        fs::write(&path, [&bytes[..PAGE_BYTES], &vec![0xFF; bytes.len() - PAGE_BYTES]].concat()).unwrap();
        assert_eq!(stored(&path), (0, StoredState::Damaged));
        fs::remove_file(&path).unwrap();
        let missing = FlashFile::open(&path, |_| ()).map(drop).unwrap_err().to_string();
        assert!(missing.contains("is missing, but `") && missing.contains("board.flash.stored` shows"), "{missing}");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_file_that_cannot_be_written_stores_nothing_and_says_so() {
        let folder = folder("full");
        let path = folder.join("board.flash");
        at_board(&path, |session| set_and_store(session, "3.5").unwrap());
        let before = fs::read(&path).unwrap();
        let (flash, file) = FlashFile::open(&path, |_| ()).unwrap();
        let mut board = Settings::new(flash).unwrap();
        let blocker = folder.join("board.flash.unfinished");
        fs::create_dir(&blocker).unwrap();
        assert!(board.clear().is_err());
        let why = file.check().unwrap_err().to_string();
        assert!(why.contains("board.flash` cannot be written: ") && why.contains("NOT stored"), "{why}");
        at_board(&path, |session| {
            let refused = set_and_store(session, "4.5").unwrap_err().to_string();
            assert!(refused.contains("flash memory has failed"), "{refused}");
        });
        assert_eq!(fs::read(&path).unwrap(), before);
        fs::remove_dir(&blocker).unwrap();
        assert!(board.clear().is_ok() && file.check().is_ok());
        assert!(fs::read(&path).unwrap() != before && !blocker.exists());
        fs::remove_dir_all(folder).unwrap();
    }
}
