//! How much of the processor the block interrupt takes.

use cortex_m4::Cycle;

/// What the block interrupt has taken, entry and return included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Load {
    /// Blocks counted.
    pub blocks: u64,
    /// Cycles of all of them.
    pub cycles: Cycle,
    /// Cycles of the longest.
    pub worst_cycles: Cycle,
    /// Instructions of all of them.
    pub instructions: u64,
    /// The most instructions of one.
    pub worst_instructions: u64,
}

impl Load {
    pub(crate) fn add(&mut self, cycles: Cycle, instructions: u64) {
        self.blocks += 1;
        self.cycles += cycles;
        self.worst_cycles = self.worst_cycles.max(cycles);
        self.instructions += instructions;
        self.worst_instructions = self.worst_instructions.max(instructions);
    }

    /// Mean cycles of a block; zero before the first.
    pub fn mean_cycles(&self) -> f64 {
        self.cycles as f64 / self.blocks.max(1) as f64
    }

    /// Mean instructions of a block; zero before the first.
    pub fn mean_instructions(&self) -> f64 {
        self.instructions as f64 / self.blocks.max(1) as f64
    }
}
