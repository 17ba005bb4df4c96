//! Report of the hardware that a board runs on: microcontroller, clock, and time of a block.

use serde::{Deserialize, Serialize};

/// Clock of the processor and of the converters. Its number on the wire is its place in this list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Clock {
    /// Not a board with a clock of its own, such as a simulated one.
    #[default]
    Unknown,
    /// A crystal.
    Crystal,
    /// The internal oscillator of the microcontroller: the crystal did not start, or has failed.
    Internal,
}

/// Hardware of a board. All zero on a simulated board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HardwareReport {
    /// Device of the microcontroller, as it identifies itself.
    pub device: u16,
    /// Silicon revision of the microcontroller, as it identifies itself.
    pub revision: u16,
    /// Option bytes with unexpected values, one bit each.
    pub option_bytes: u16,
    /// Clock of the processor and of the converters.
    pub clock: Clock,
    /// Nominal frequency of the processor, Hz.
    pub core_hz: u32,
    /// Duration of a block, cycles.
    pub block_cycles: u32,
    /// Longest block interrupt since the start, cycles.
    pub worst_cycles: u32,
    /// `true` if the enable of the amplifier is kept low.
    pub muted: bool,
}
