//! Flash and RAM, and the instructions decoded from them.

use crate::op::Decoded;

/// A memory of the part: bytes that answer at once, or after wait states that the part knows.
#[derive(Clone, Debug)]
pub struct Region {
    /// Address of the first byte.
    pub base: u32,
    /// The bytes, little-endian.
    pub bytes: Vec<u8>,
    /// Stores of the processor reach it. Those to flash go to [`Chip::write`](crate::Chip::write).
    pub writable: bool,
    /// Fetches and loads ask the part for wait states.
    pub waits: bool,
}

/// Bytes of a page: what is decoded is dropped instruction by instruction, but only looked for in pages that have any.
const PAGE: usize = 256;

/// A region with the instructions decoded from it.
#[derive(Clone, Debug)]
pub(crate) struct Bank {
    pub(crate) region: Region,
    /// An entry a halfword; empty until something of the region runs.
    pub(crate) code: Vec<Decoded>,
    /// Whether something of a page is decoded.
    pages: Vec<bool>,
}

impl Bank {
    /// Stores a decoded instruction at byte `from`.
    pub(crate) fn remember(&mut self, from: usize, decoded: Decoded) {
        if self.code.is_empty() {
            self.code = vec![Decoded::NOTHING; self.region.bytes.len() / 2];
            self.pages = vec![false; self.region.bytes.len() / PAGE + 1];
        }
        self.code[from / 2] = decoded;
        self.pages[from / PAGE] = true;
        self.pages[(from + 3) / PAGE] = true;
    }

    /// Drops what was decoded from the bytes `from..from + len`, which are about to change.
    #[inline]
    pub(crate) fn forget(&mut self, from: usize, len: usize) {
        // Empty as long as nothing was decoded.
        let Some(pages) = self.pages.get(from / PAGE..=(from + len.max(1) - 1) / PAGE) else { return };
        if pages.contains(&true) {
            // An instruction may begin one halfword before and reach into these bytes.
            let first = (from / 2).saturating_sub(1);
            let last = (from + len).div_ceil(2).min(self.code.len());
            self.code[first..last].fill(Decoded::NOTHING);
        }
    }
}

/// All memories of the part.
#[derive(Clone, Debug)]
pub struct Memory {
    pub(crate) banks: Vec<Bank>,
    /// By the top byte of an address, the first bank that begins there, or one that does not exist.
    pub(crate) by_top: [u8; 256],
    /// Aligned 8 bytes that read as damaged.
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

    /// The regions in the order in which they were added.
    pub fn regions(&self) -> impl Iterator<Item = &Region> {
        self.banks.iter().map(|bank| &bank.region)
    }

    /// The bytes from `address` on; none where there is no memory, or it ends before.
    pub fn get(&self, address: u32, len: usize) -> Option<&[u8]> {
        self.banks.iter().find_map(|bank| {
            let from = address.checked_sub(bank.region.base)? as usize;
            bank.region.bytes.get(from..from.checked_add(len)?)
        })
    }

    /// The same, to be written: by DMA, by the programming of flash, by a debugger, by what flips a bit. The processor notices when the code that it runs is changed.
    pub fn get_mut(&mut self, address: u32, len: usize) -> Option<&mut [u8]> {
        self.banks.iter_mut().find_map(|bank| {
            let from = address.checked_sub(bank.region.base)? as usize;
            let to = from.checked_add(len)?;
            if to > bank.region.bytes.len() {
                return None;
            }
            bank.forget(from, len);
            bank.region.bytes.get_mut(from..to)
        })
    }

    /// From now on a read of the aligned 8 bytes at `address` is reported to [`Chip::damaged`](crate::Chip::damaged).
    pub fn damage(&mut self, address: u32) {
        let address = address & !7;
        if !self.damaged.contains(&address) {
            self.damaged.push(address);
        }
    }

    /// The 8 bytes at `address` are whole again (they were erased).
    pub fn mend(&mut self, address: u32) {
        self.damaged.retain(|damaged| *damaged != address & !7);
    }

    /// Whether the aligned 8 bytes at `word` are damaged.
    pub(crate) fn is_damaged(&self, word: u32) -> bool {
        self.damaged.contains(&word)
    }

    /// The region that holds `address`: its number, and the byte within.
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
