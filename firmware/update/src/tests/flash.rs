//! NOR flash like that of an STM32G4: double words can be written once, or overwritten with zeros
//! (RM0440 3.3.7). Words cut by a power failure are damaged.

use std::cell::RefCell;
use std::rc::Rc;
use std::vec;
use std::vec::Vec;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// Size of a page, bytes: smaller than on the STM32G4, so that every operation can be cut.
pub const PAGE_BYTES: usize = 512;
const WORD_BYTES: usize = 8;

/// Result of reading a damaged word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DamagedRead {
    /// Zeros: the driver's answer to an uncorrectable error.
    Zeros,
    /// Some of the new bits: an undetected error.
    Bits,
}

/// Error of an access that was not performed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed;

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// Flash with its supply.
#[derive(Clone, Debug)]
pub struct FlashPart {
    pub bytes: Vec<u8>,
    written: Vec<bool>,
    damaged: Vec<bool>,
    /// Number of erases and written words so far.
    pub operations: u64,
    /// Number of the operation during which the power fails.
    pub cut: Option<u64>,
    off: bool,
    reads: DamagedRead,
    seed: u64,
}

impl FlashPart {
    /// Creates an erased flash.
    pub fn new(pages: usize, reads: DamagedRead) -> Self {
        let words = pages * PAGE_BYTES / WORD_BYTES;
        let (bytes, written, damaged) = (vec![0xff; pages * PAGE_BYTES], vec![false; words], vec![false; words]);
        FlashPart { bytes, written, damaged, operations: 0, cut: None, off: false, reads, seed: 1 }
    }

    /// Returns `true` after a power cut.
    pub fn is_off(&self) -> bool {
        self.off
    }

    /// Restores the power, without a further cut.
    pub fn power(&mut self) {
        (self.off, self.cut) = (false, None);
    }

    /// Stores bytes like a probe.
    pub fn load(&mut self, at: usize, bytes: &[u8]) {
        self.bytes[at..at + bytes.len()].copy_from_slice(bytes);
        self.written[at / WORD_BYTES..(at + bytes.len()).div_ceil(WORD_BYTES)].fill(true);
    }

    /// Damages a word.
    pub fn damage(&mut self, at: usize) {
        self.damaged[at / WORD_BYTES] = true;
        self.bytes[at] ^= 3;
    }

    /// Counts an operation. Returns `true` if the power fails during it.
    fn count_operation(&mut self) -> bool {
        self.operations += 1;
        self.off = self.cut == Some(self.operations);
        self.off
    }

    /// Changes a random part of the differing bits. Random numbers of Marsaglia's xorshift (J.
    /// Stat. Softw. 8, 2003).
    fn some(&mut self, from: u8, to: u8) -> u8 {
        self.seed ^= self.seed << 13;
        self.seed ^= self.seed >> 7;
        self.seed ^= self.seed << 17;
        from ^ ((from ^ to) & self.seed as u8)
    }

    fn change(&mut self, at: usize, to: &[u8], cut: bool) {
        for (n, &to) in to.iter().enumerate() {
            self.bytes[at + n] = if cut { self.some(self.bytes[at + n], to) } else { to };
        }
    }
}

/// Area of the flash.
#[derive(Clone, Debug)]
pub struct Area {
    pub part: Rc<RefCell<FlashPart>>,
    pub from: usize,
    pub size: usize,
}

impl ErrorType for Area {
    type Error = Failed;
}

impl ReadNorFlash for Area {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, into: &mut [u8]) -> Result<(), Failed> {
        let part = self.part.borrow();
        if part.off || offset as usize + into.len() > self.size {
            return Err(Failed);
        }
        for (at, byte) in (self.from + offset as usize..).zip(into) {
            *byte = if part.damaged[at / WORD_BYTES] && part.reads == DamagedRead::Zeros { 0 } else { part.bytes[at] };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.size
    }
}

impl NorFlash for Area {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = PAGE_BYTES;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        assert!(from.is_multiple_of(PAGE_BYTES as u32) && to.is_multiple_of(PAGE_BYTES as u32) && to as usize <= self.size);
        for page in (from as usize..to as usize).step_by(PAGE_BYTES) {
            let (at, mut part) = (self.from + page, self.part.borrow_mut());
            if part.off {
                return Err(Failed);
            }
            let cut = part.count_operation();
            part.change(at, &[0xff; PAGE_BYTES], cut);
            part.written[at / WORD_BYTES..(at + PAGE_BYTES) / WORD_BYTES].fill(cut);
            part.damaged[at / WORD_BYTES..(at + PAGE_BYTES) / WORD_BYTES].fill(cut);
            if cut {
                return Err(Failed);
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        assert!(
            (offset as usize).is_multiple_of(WORD_BYTES)
                && bytes.len().is_multiple_of(WORD_BYTES)
                && offset as usize + bytes.len() <= self.size
        );
        for (at, word) in (self.from + offset as usize..).step_by(WORD_BYTES).zip(bytes.chunks_exact(WORD_BYTES)) {
            let mut part = self.part.borrow_mut();
            let overwrites = part.written[at / WORD_BYTES] && word != [0; WORD_BYTES];
            if part.off || overwrites {
                assert!(!overwrites, "a word is written twice, and not with zeros");
                return Err(Failed);
            }
            let cut = part.count_operation();
            part.change(at, word, cut);
            (part.written[at / WORD_BYTES], part.damaged[at / WORD_BYTES]) = (true, cut);
            if cut {
                return Err(Failed);
            }
        }
        Ok(())
    }
}
