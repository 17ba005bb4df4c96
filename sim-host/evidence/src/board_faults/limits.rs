//! The required response to a fault, and its time limit: the protection table of `docs/board.md`.

use nucleo_g474re::blocks::{BLOCK, MISSED};

/// Length of a block, s.
pub const BLOCK_S: f64 = BLOCK as f64 * 1e-6;
/// Time in which hardware acts, s: a comparator, a break of TIM1, and the sample of the plant that
/// contains it.
const HARDWARE_S: f64 = 1e-6;
/// Time in which the block interrupt is entered, checks the streams and restarts the count of time
/// without a block, s. It contains the longest time with interrupts masked, 6.0 us
/// (`sim-host run dummy-load --board --board-speed 8`).
const ENTRY_S: f64 = 8e-6;
/// Watchdog timeout, s.
const WATCHDOG_S: f64 = 10e-3;
/// Relative tolerance of the watchdog's oscillator (DS12288).
const WATCHDOG_TOLERANCE: f64 = 0.05;
/// Host timeout of these runs, s.
pub const HOST_S: f64 = 20e-3;

/// Time until the amplifier must be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Hardware, without the processor.
    Hardware,
    /// "1 block": the interrupt at the end of the block that contains the fault acts.
    OneBlock,
    /// "8 blocks" and so on (`seam::fault`): whole blocks after the one that contains the fault,
    /// and the block of the interrupt that mutes.
    Blocks(u32),
    /// "No block for 200 us".
    NoBlock,
    /// "10 ms (±5 %)".
    Watchdog,
    /// The host timeout and two blocks.
    HostTimeout,
}

impl Limit {
    /// Returns the limit, s.
    pub fn seconds(self) -> f64 {
        match self {
            Limit::Hardware => HARDWARE_S,
            Limit::OneBlock => BLOCK_S + ENTRY_S,
            Limit::Blocks(blocks) => f64::from(blocks + 2) * BLOCK_S,
            // The last block may be complete, but its interrupt not entered yet.
            Limit::NoBlock => f64::from(MISSED) * BLOCK_S + ENTRY_S,
            Limit::Watchdog => WATCHDOG_S / (1.0 - WATCHDOG_TOLERANCE),
            Limit::HostTimeout => HOST_S + 2.0 * BLOCK_S,
        }
    }
}

/// Required response to a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The amplifier is off, or the drive muted, within this time, and one of the reasons is
    /// reported.
    Off(Limit),
    /// The drive continues unchanged.
    DrivesOn,
    /// Either of the two; if it is off, a reason is reported.
    OffOrDrivesOn,
}

/// Returns the frequency of the watchdog's oscillator, Hz, at a fraction of its tolerance from -1
/// to 1.
pub fn lsi_hz(part: f64) -> u64 {
    (32_000.0 * (1.0 + WATCHDOG_TOLERANCE * part)) as u64
}
