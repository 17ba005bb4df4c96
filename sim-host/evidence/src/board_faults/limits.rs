//! What must come of a fault, and how soon: the protection table of `docs/board.md`.

use nucleo_g474re::blocks::{BLOCK, MISSED};

/// A block, s.
pub const BLOCK_S: f64 = BLOCK as f64 * 1e-6;
/// The time in which hardware acts: a comparator, a break of TIM1, and the sample of the plant that it falls into, s.
const HARDWARE_S: f64 = 1e-6;
/// The time in which the block interrupt is entered, and has looked at the streams and started the count without a block again, s: the longest time with interrupts
/// masked, 6.0 us (`sim-host run dummy-load --board --board-speed 8`), and what it does until then.
const ENTRY_S: f64 = 8e-6;
/// The watchdog, s, and the tolerance of its oscillator (DS12288).
const WATCHDOG_S: f64 = 10e-3;
const WATCHDOG_TOLERANCE: f64 = 0.05;
/// The host timeout of these runs, s.
pub const HOST_S: f64 = 20e-3;

/// The time until the amplifier must be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Hardware, without the processor.
    Hardware,
    /// "1 block": the interrupt at the end of the block that the fault falls into acts.
    OneBlock,
    /// "8 blocks" and so on (`seam::fault`): whole blocks after the one that the fault falls into, and that of the interrupt that mutes.
    Blocks(u32),
    /// "No block for 200 us".
    NoBlock,
    /// "10 ms (±5 %)".
    Watchdog,
    /// The host timeout, and a block.
    HostTimeout,
}

impl Limit {
    /// The limit, s.
    pub fn seconds(self) -> f64 {
        match self {
            Limit::Hardware => HARDWARE_S,
            Limit::OneBlock => BLOCK_S + ENTRY_S,
            Limit::Blocks(blocks) => f64::from(blocks + 2) * BLOCK_S,
            // The last block may be complete, and its interrupt not entered yet.
            Limit::NoBlock => f64::from(MISSED) * BLOCK_S + ENTRY_S,
            Limit::Watchdog => WATCHDOG_S / (1.0 - WATCHDOG_TOLERANCE),
            Limit::HostTimeout => HOST_S + 2.0 * BLOCK_S,
        }
    }
}

/// What must come of a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The amplifier is off, or the drive muted, within this time, and one of the reasons is named.
    Off(Limit),
    /// The drive goes on as before.
    DrivesOn,
    /// Either of the two; a reason is named where it is off.
    OffOrDrivesOn,
}

/// The watchdog's oscillator at a part of its tolerance, -1 to 1, Hz.
pub fn lsi_hz(part: f64) -> u64 {
    (32_000.0 * (1.0 + WATCHDOG_TOLERANCE * part)) as u64
}
