//! Blocks of this board: their length, their clock, and the rings that follow from both.

use boards_common::{beat, half, step};

/// Samples in a block: as many as the part has time for, in whole periods of 40 kHz and of 20 kHz.
///
/// Most of what a block costs does not depend on its length. Blocks of 64 were measured before this was chosen: `docs/board.md`.
pub const BLOCK: usize = 100;
/// Blocks that may be missed before the amplifier's enable drops, but for a part of one.
pub const MISSED: u32 = 2;
/// Samples in a ring.
pub const RING: usize = 2 * BLOCK;
/// Words that a DAC holds: a trigger plays the word that the trigger before has fetched (RM0440 22.4.8).
pub const AHEAD: usize = 1;
/// Cycles of the processor in a sample: 170 MHz at 1 Msps.
pub const CYCLES_PER_SAMPLE: u32 = 170;
/// Cycles of the processor in a block.
pub const CYCLES_PER_BLOCK: u32 = CYCLES_PER_SAMPLE * BLOCK as u32;

/// A half of a ring.
pub type Half = half::Half<RING>;
/// Whether the rings of the ADC and of the DACs are in step. The moment of each sample in which one has moved and the other has not takes some 8 cycles
/// of 170 ([`TRIGGER_AFTER`](crate::sampling::TRIGGER_AFTER)).
pub type Step = step::Step<RING>;
/// Blocks that were missed.
pub type Beat = beat::Beat<CYCLES_PER_BLOCK>;
