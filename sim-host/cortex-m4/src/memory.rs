//! Flash and RAM.

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

/// All memories of the part.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    regions: Vec<Region>,
    /// Aligned 8 bytes that read as damaged.
    damaged: Vec<u32>,
}

impl Memory {
    /// Adds a memory.
    pub fn add(&mut self, region: Region) {
        self.regions.push(region);
    }

    /// The bytes from `address` on; none where there is no memory, or it ends before.
    pub fn get(&self, address: u32, len: usize) -> Option<&[u8]> {
        self.regions.iter().find_map(|region| {
            let from = address.checked_sub(region.base)? as usize;
            region.bytes.get(from..from.checked_add(len)?)
        })
    }

    /// The same, to be written: by DMA, by the programming of flash, by a debugger, by what flips a bit. The processor notices when the code that it runs is changed.
    pub fn get_mut(&mut self, address: u32, len: usize) -> Option<&mut [u8]> {
        self.regions.iter_mut().find_map(|region| {
            let from = address.checked_sub(region.base)? as usize;
            region.bytes.get_mut(from..from.checked_add(len)?)
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
}
