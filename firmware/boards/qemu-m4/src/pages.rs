//! Flash in RAM for the stored settings: a word is written once after each erase of its page, and
//! can only lose bits.
//!
//! It is lost when the emulator ends. Power cuts are tested on the host (`hal-mock`).

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write};

/// Number of pages.
pub const PAGES: usize = 4;
/// Size of a page, bytes, as on the reference board.
pub const PAGE_BYTES: usize = 2048;
/// Size of the unit of writing, bytes.
const WORD_BYTES: usize = 8;
const ERASED: u8 = 0xff;

/// Flash of a few pages in RAM.
#[repr(C)]
pub struct Pages {
    bytes: [u8; PAGES * PAGE_BYTES],
}

impl Pages {
    /// Creates an erased flash.
    pub const fn new() -> Self {
        Pages { bytes: [ERASED; PAGES * PAGE_BYTES] }
    }

    /// Erases all pages.
    pub fn clear(&mut self) {
        self.bytes.fill(ERASED);
    }
}

impl Default for Pages {
    fn default() -> Self {
        Pages::new()
    }
}

impl ErrorType for Pages {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Pages {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, into: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, into.len())?;
        into.copy_from_slice(&self.bytes[offset as usize..][..into.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Pages {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = PAGE_BYTES;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        self.bytes[from as usize..to as usize].fill(ERASED);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        let room = &mut self.bytes[offset as usize..][..bytes.len()];
        // A word cannot be written twice, as on the reference board.
        let is_written = |words: &mut &mut [u8]| words.iter().any(|&byte| byte != ERASED);
        if room.chunks_mut(WORD_BYTES).any(|mut word| is_written(&mut word)) {
            return Err(NorFlashErrorKind::Other);
        }
        room.copy_from_slice(bytes);
        Ok(())
    }
}
