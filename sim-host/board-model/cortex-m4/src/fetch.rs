//! Fetch of instructions. Each is decoded once, and stored next to its bytes.

use crate::chip::Chip;
use crate::cpu::{INVALID, Trap};
use crate::decode;
use crate::machine::Machine;
use crate::op::Decoded;

impl<C: Chip> Machine<C> {
    /// Returns the decoded instruction at `pc`, if any, and `true` if its memory has wait states.
    #[inline(always)]
    pub(crate) fn cached(&self, pc: u32) -> Option<(&Decoded, bool)> {
        let bank = self.memory.banks.get(usize::from(self.memory.by_top[(pc >> 24) as usize]))?;
        // The rotation moves the lowest bit, INVALID, to the top, which is beyond any region.
        let decoded = bank.code.get(pc.wrapping_sub(bank.region.base).rotate_right(INVALID) as usize)?;
        (decoded.len != 0).then_some((decoded, bank.region.waits))
    }

    /// Decodes the instruction at `pc`, or takes the fault of its fetch.
    #[cold]
    #[inline(never)]
    pub(crate) fn prepare(&mut self, pc: u32) -> Result<(), Trap> {
        self.fetch(pc).or_else(|trap| {
            self.cpu.next = pc;
            self.cpu.instructions += 1;
            self.take(trap)
        })
    }

    /// Decodes an instruction and stores it next to its bytes.
    fn fetch(&mut self, pc: u32) -> Result<(), Trap> {
        if pc & INVALID != 0 {
            return Err(Trap::InvalidState);
        }
        // Code cannot run from device memory or the system space (B3.1).
        if matches!(pc >> 29, 2 | 5..) {
            return Err(Trap::MemoryFetch);
        }
        let (bank, from) = self.memory.find(pc).ok_or(Trap::Fetch)?;
        let bytes = &self.memory.banks[bank].region.bytes;
        let half = |at: usize| bytes.get(at..at + 2).map(|bytes| u16::from_le_bytes([bytes[0], bytes[1]]));
        let first = half(from).ok_or(Trap::Fetch)?;
        let second = half(from + 2).unwrap_or(0);
        if decode::is_wide(first) && from + 4 > bytes.len() {
            return Err(Trap::Fetch);
        }
        let decoded = decode::decode(pc, first, second);
        self.memory.banks[bank].remember(from, decoded);
        Ok(())
    }

    /// Adds the wait states of an instruction in the aligned 8 bytes at `first` and `last`, fetched
    /// after those at `before`.
    #[inline]
    pub(crate) fn fetch_wait(&mut self, first: u32, before: u32, last: u32) {
        if first != before {
            self.cpu.cost += self.chip.fetch_wait(first, self.cpu.cycle);
        }
        if last != first {
            self.cpu.cost += self.chip.fetch_wait(last, self.cpu.cycle);
        }
    }
}
