//! Flash and RAM, with the instructions decoded from them.

use crate::op::Decoded;

/// Memory of the chip, without wait states or with wait states that the chip states.
#[derive(Clone, Debug)]
pub struct Region {
    /// Address of the first byte.
    pub base: u32,
    /// Contents, little-endian.
    pub bytes: Vec<u8>,
    /// `true` if the processor can store to it. Stores to flash go to
    /// [`Chip::write`](crate::Chip::write).
    pub writable: bool,
    /// `true` if fetches and loads have wait states, which the chip returns.
    pub waits: bool,
}

/// Bytes of a page. Stores search for decoded instructions only in pages that have any.
const PAGE_BYTES: usize = 256;

/// Region with the instructions decoded from it.
#[derive(Clone, Debug)]
pub(crate) struct Bank {
    pub(crate) region: Region,
    /// One entry per halfword; empty until code of the region runs.
    pub(crate) code: Vec<Decoded>,
    /// `true` for each page with decoded instructions.
    pages: Vec<bool>,
}

impl Bank {
    /// Stores a decoded instruction at byte `from`.
    pub(crate) fn remember(&mut self, from: usize, decoded: Decoded) {
        if self.code.is_empty() {
            self.code = vec![Decoded::NOTHING; self.region.bytes.len() / 2];
            self.pages = vec![false; self.region.bytes.len() / PAGE_BYTES + 1];
        }
        self.code[from / 2] = decoded;
        self.pages[from / PAGE_BYTES] = true;
        self.pages[(from + 3) / PAGE_BYTES] = true;
    }

    /// Drops the instructions decoded from the bytes `from..from + len`, which are about to change.
    #[inline]
    pub(crate) fn drop_decoded(&mut self, from: usize, len: usize) {
        // Empty until something is decoded.
        let Some(pages) = self.pages.get(from / PAGE_BYTES..=(from + len.max(1) - 1) / PAGE_BYTES) else { return };
        if pages.contains(&true) {
            // An instruction may begin one halfword earlier and extend into these bytes.
            let first = (from / 2).saturating_sub(1);
            let last = (from + len).div_ceil(2).min(self.code.len());
            self.code[first..last].fill(Decoded::NOTHING);
        }
    }
}

/// All memories of the chip.
#[derive(Clone, Debug)]
pub struct Memory {
    pub(crate) banks: Vec<Bank>,
    /// First bank for each top byte of an address, or the number of a bank that does not exist.
    pub(crate) by_top: [u8; 256],
    /// Addresses of aligned 8 bytes that read as damaged.
    pub(crate) damaged: Vec<u32>,
}

impl Default for Memory {
    fn default() -> Memory {
        Memory { banks: Vec::new(), by_top: [u8::MAX; 256], damaged: Vec::new() }
    }
}

impl Memory {
    /// Adds a memory.
    pub fn add(&mut self, region: Region) {
        let first = &mut self.by_top[(region.base >> 24) as usize];
        *first = (*first).min(self.banks.len() as u8);
        self.banks.push(Bank { region, code: Vec::new(), pages: Vec::new() });
    }

    /// Returns the regions in the order in which they were added.
    pub fn regions(&self) -> impl Iterator<Item = &Region> {
        self.banks.iter().map(|bank| &bank.region)
    }

    /// Returns `len` bytes at `address`; `None` if a memory does not contain all of them.
    pub fn get(&self, address: u32, len: usize) -> Option<&[u8]> {
        self.banks.iter().find_map(|bank| {
            let from = address.checked_sub(bank.region.base)? as usize;
            bank.region.bytes.get(from..from.checked_add(len)?)
        })
    }

    /// Returns `len` bytes at `address` for writing, by DMA, flash programming, a debugger, or a
    /// bit flip. Instructions decoded from them are dropped.
    pub fn get_mut(&mut self, address: u32, len: usize) -> Option<&mut [u8]> {
        self.banks.iter_mut().find_map(|bank| {
            let from = address.checked_sub(bank.region.base)? as usize;
            let to = from.checked_add(len)?;
            if to > bank.region.bytes.len() {
                return None;
            }
            bank.drop_decoded(from, len);
            bank.region.bytes.get_mut(from..to)
        })
    }

    /// Marks the aligned 8 bytes at `address` as damaged: reads are reported to
    /// [`Chip::damaged`](crate::Chip::damaged).
    pub fn damage(&mut self, address: u32) {
        let address = address & !7;
        if !self.damaged.contains(&address) {
            self.damaged.push(address);
        }
    }

    /// Removes the mark of the 8 bytes at `address`, after an erase.
    pub fn clear_damage(&mut self, address: u32) {
        self.damaged.retain(|damaged| *damaged != address & !7);
    }

    /// Returns `true` if the aligned 8 bytes at `word` are damaged.
    pub(crate) fn is_damaged(&self, word: u32) -> bool {
        self.damaged.contains(&word)
    }

    /// Returns the number of the region that contains `address`, and the byte offset in it.
    #[inline]
    pub(crate) fn find(&self, address: u32) -> Option<(usize, usize)> {
        let likely = usize::from(self.by_top[(address >> 24) as usize]);
        if let Some(bank) = self.banks.get(likely) {
            let from = address.wrapping_sub(bank.region.base) as usize;
            if from < bank.region.bytes.len() {
                return Some((likely, from));
            }
        }
        self.search(address)
    }

    fn search(&self, address: u32) -> Option<(usize, usize)> {
        self.banks.iter().enumerate().find_map(|(number, bank)| {
            let from = address.checked_sub(bank.region.base)? as usize;
            (from < bank.region.bytes.len()).then_some((number, from))
        })
    }
}
