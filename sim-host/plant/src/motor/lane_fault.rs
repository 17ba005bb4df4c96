//! What breaks in a lane of a motor.
//!
//! | fault | what it does |
//! |---|---|
//! | `lane_open` | the electrodes are not connected: the amplifier's voltage stays, its current is none, and the electrodes float |
//! | `lane_weak` | the amplifier plays a part of its voltage |
//! | `lane_reversed` | the amplifier plays the opposite |
//! | `lanes_exchanged` | two amplifiers have each other's input |
//!
//! The multiplexer is at the amplifiers' terminals. What is exchanged or reversed behind it (two wires to the electrodes) is not simulated.

use scene::{Driven, FaultKind};

/// What a lane that is weak plays of its voltage, unless the scene says otherwise.
const WEAK: f64 = 0.5;

/// A fault of one lane, or of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LaneFault {
    /// The electrodes are not connected.
    Open { lane: usize },
    /// The amplifier plays this part of its voltage, the opposite where it is negative.
    Weak { lane: usize, part: f64 },
    /// Two amplifiers have each other's input.
    Exchanged { one: usize, other: usize },
}

/// The faults of a scene's lanes, each with the block of `block_s` seconds that it happens in.
pub(super) fn lane_faults(scene: &Driven, block_s: f64) -> Vec<(u64, LaneFault)> {
    let of = |fault: &scene::Fault| {
        let lane = usize::from(fault.lane?);
        let fault_of_lane = match fault.kind {
            FaultKind::LaneOpen => LaneFault::Open { lane },
            FaultKind::LaneWeak => LaneFault::Weak { lane, part: fault.gain.unwrap_or(WEAK) },
            FaultKind::LaneReversed => LaneFault::Weak { lane, part: -1.0 },
            FaultKind::LanesExchanged => LaneFault::Exchanged { one: lane, other: fault.other_lane?.into() },
            _ => return None,
        };
        Some(((fault.at_s / block_s) as u64, fault_of_lane))
    };
    scene.fault.iter().filter_map(of).collect()
}
