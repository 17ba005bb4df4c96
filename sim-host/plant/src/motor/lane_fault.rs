//! Faults of a lane of a motor.
//!
//! | fault | effect |
//! |---|---|
//! | `lane_open` | the electrodes are not connected: the amplifier keeps its voltage without current, and the electrodes float |
//! | `lane_weak` | the amplifier plays a fraction of its voltage |
//! | `lane_reversed` | the amplifier plays the opposite |
//! | `lanes_exchanged` | the inputs of two amplifiers are exchanged |
//!
//! The multiplexer is at the amplifiers' terminals. An exchange or reversal after it (two wires to
//! the electrodes) is not simulated.

use scene::{Driven, FaultKind};

/// Default fraction of its voltage that a weak lane plays.
const WEAK_GAIN: f64 = 0.5;

/// A fault of one lane, or of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LaneFault {
    /// The electrodes are not connected.
    Open { lane: usize },
    /// The amplifier plays this fraction of its voltage, with the opposite sign if negative.
    Weak { lane: usize, part: f64 },
    /// The inputs of two amplifiers are exchanged.
    Exchanged { one: usize, other: usize },
}

/// Returns the faults of a scene's lanes, each with its block of `block_s` seconds.
pub(super) fn lane_faults(scene: &Driven, block_s: f64) -> Vec<(u64, LaneFault)> {
    let of = |fault: &scene::Fault| {
        let lane = usize::from(fault.lane?);
        let fault_of_lane = match fault.kind {
            FaultKind::LaneOpen => LaneFault::Open { lane },
            FaultKind::LaneWeak => LaneFault::Weak { lane, part: fault.gain.unwrap_or(WEAK_GAIN) },
            FaultKind::LaneReversed => LaneFault::Weak { lane, part: -1.0 },
            FaultKind::LanesExchanged => LaneFault::Exchanged { one: lane, other: fault.other_lane?.into() },
            _ => return None,
        };
        Some(((fault.at_s / block_s) as u64, fault_of_lane))
    };
    scene.fault.iter().filter_map(of).collect()
}
