//! Blocks of this board: their length, their clock, and their rings.

use boards_common::{beat, half, step};

/// Number of samples in a block. The processor has time for this length, and it contains whole
/// periods of 40 kHz and of 20 kHz.
///
/// Most of the computing time of a block does not depend on its length. Blocks of 64 samples were
/// measured before this length was chosen: `docs/board.md`.
pub const BLOCK: usize = 100;
/// Number of missed blocks after which the hardware drops the amplifier's enable, to within part of
/// a block.
pub const MISSED: u32 = 2;
/// Number of samples in a ring.
pub const RING: usize = 2 * BLOCK;
/// Number of words that a DAC fetches before it plays them: a trigger plays the word fetched by the
/// trigger before (RM0440 22.4.8).
pub const AHEAD: usize = 1;
/// Processor cycles per sample: 170 MHz at 1 Msps.
pub const CYCLES_PER_SAMPLE: u32 = 170;
/// Processor cycles per block.
pub const CYCLES_PER_BLOCK: u32 = CYCLES_PER_SAMPLE * BLOCK as u32;

/// Half of a ring.
pub type Half = half::Half<RING>;
/// Check that the rings of the ADC and of the DACs are in step.
pub type Step = step::Step<RING>;
/// Counter of missed blocks.
pub type Beat = beat::Beat<CYCLES_PER_BLOCK>;
