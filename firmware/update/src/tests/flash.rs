//! NOR flash as an STM32G4 has it: double words that are written once, or over by zeros (RM0440 3.3.7); what a power cut has left is damaged.

use std::cell::RefCell;
use std::rc::Rc;
use std::vec;
use std::vec::Vec;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// Bytes of a page: less than the part's, so that every operation can be cut.
pub const PAGE: usize = 512;
const WORD: usize = 8;

/// What a damaged word reads as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Torn {
    /// Zeros: the driver's answer to an error that cannot be corrected.
    Zeros,
    /// Some of its bits: an error that was not found.
    Bits,
}

/// Why nothing was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed;

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// A flash with its supply.
#[derive(Clone, Debug)]
pub struct Part {
    pub bytes: Vec<u8>,
    written: Vec<bool>,
    torn: Vec<bool>,
    /// Erases and words so far.
    pub operations: u64,
    /// The operation that is cut.
    pub cut: Option<u64>,
    off: bool,
    reads: Torn,
    seed: u64,
}

impl Part {
    /// An erased one.
    pub fn new(pages: usize, reads: Torn) -> Self {
        let words = pages * PAGE / WORD;
        let (bytes, written, torn) = (vec![0xff; pages * PAGE], vec![false; words], vec![false; words]);
        Part { bytes, written, torn, operations: 0, cut: None, off: false, reads, seed: 1 }
    }

    /// Whether the power was cut.
    pub fn is_off(&self) -> bool {
        self.off
    }

    /// The power comes back, and stays.
    pub fn power(&mut self) {
        (self.off, self.cut) = (false, None);
    }

    /// Stores bytes as a probe does.
    pub fn load(&mut self, at: usize, bytes: &[u8]) {
        self.bytes[at..at + bytes.len()].copy_from_slice(bytes);
        self.written[at / WORD..(at + bytes.len()).div_ceil(WORD)].fill(true);
    }

    /// Damages a word.
    pub fn damage(&mut self, at: usize) {
        self.torn[at / WORD] = true;
        self.bytes[at] ^= 3;
    }

    /// Counts an operation; whether it is cut.
    fn is_cut(&mut self) -> bool {
        self.operations += 1;
        self.off = self.cut == Some(self.operations);
        self.off
    }

    /// Some bits of those that differ. Numbers of Marsaglia's xorshift (J. Stat. Softw. 8, 2003).
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

/// A part of the flash.
#[derive(Clone, Debug)]
pub struct Area {
    pub part: Rc<RefCell<Part>>,
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
            *byte = if part.torn[at / WORD] && part.reads == Torn::Zeros { 0 } else { part.bytes[at] };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.size
    }
}

impl NorFlash for Area {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        assert!(from.is_multiple_of(PAGE as u32) && to.is_multiple_of(PAGE as u32) && to as usize <= self.size);
        for page in (from as usize..to as usize).step_by(PAGE) {
            let (at, mut part) = (self.from + page, self.part.borrow_mut());
            if part.off {
                return Err(Failed);
            }
            let cut = part.is_cut();
            part.change(at, &[0xff; PAGE], cut);
            part.written[at / WORD..(at + PAGE) / WORD].fill(cut);
            part.torn[at / WORD..(at + PAGE) / WORD].fill(cut);
            if cut {
                return Err(Failed);
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        assert!(
            (offset as usize).is_multiple_of(WORD)
                && bytes.len().is_multiple_of(WORD)
                && offset as usize + bytes.len() <= self.size
        );
        for (at, word) in (self.from + offset as usize..).step_by(WORD).zip(bytes.chunks_exact(WORD)) {
            let mut part = self.part.borrow_mut();
            let overwrites = part.written[at / WORD] && word != [0; WORD];
            if part.off || overwrites {
                assert!(!overwrites, "a word is written twice, and not by zeros");
                return Err(Failed);
            }
            let cut = part.is_cut();
            part.change(at, word, cut);
            (part.written[at / WORD], part.torn[at / WORD]) = (true, cut);
            if cut {
                return Err(Failed);
            }
        }
        Ok(())
    }
}
