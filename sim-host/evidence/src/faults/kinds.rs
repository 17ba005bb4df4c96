//! What fails, and what is promised of it.

mod around;
mod drive;
mod sense;

use super::injected::Failure;
use crate::random::Random;

/// A kind of failure.
pub(super) struct Kind {
    /// Name of the kind, in tables.
    pub(super) name: &'static str,
    /// What fails, with its range.
    pub(super) what: &'static str,
    /// Draws a failure of the kind.
    pub(super) draw: fn(&mut Random) -> Failure,
    /// Faults and limits that name it rightly; empty where it is harmless.
    pub(super) named: &'static [u8],
    /// Within what time it is off, ms, where that is promised.
    pub(super) off_ms: Option<f64>,
}

/// The sense chain says something that is not so: implausible (in a motor: of a lane), open, saturated, too much, swapped, disagreeing, another mode; or the lock is lost by it.
const SENSE: &[u8] = &[20, 21, 23, 24, 25, 26, 27, 28, 31, 32, 33, 34];
/// The same, and the limits that say that the lock is in doubt.
const SENSE_OR_LIMIT: &[u8] = &[20, 21, 23, 24, 25, 26, 27, 28, 31, 32, 33, 34, 97, 98, 107];
/// A sense chain that breaks down is off within this time, ms.
const SENSE_MS: f64 = 5.0;
/// What the hardware reports, ms.
const REPORTED_MS: f64 = 0.1;

/// A part that fails, with the kinds of its failures.
pub(super) struct Part {
    /// Name of the part, in tables.
    pub(super) name: &'static str,
    /// All of its kinds.
    pub(super) kinds: &'static [Kind],
}

/// All parts.
pub(super) const PARTS: [Part; 9] = [
    Part { name: "current channel", kinds: sense::CURRENT },
    Part { name: "voltage channel", kinds: sense::VOLTAGE },
    Part { name: "converters", kinds: sense::CONVERTERS },
    Part { name: "DAC", kinds: drive::DAC },
    Part { name: "amplifier", kinds: drive::AMPLIFIER },
    Part { name: "lanes 1 to 3", kinds: drive::LANES },
    Part { name: "transducer and cable", kinds: around::TRANSDUCER },
    Part { name: "reported by hardware or host", kinds: around::REPORTED },
    Part { name: "no failure", kinds: around::NONE },
];

/// All kinds, part by part.
pub(super) fn all() -> impl Iterator<Item = &'static Kind> {
    PARTS.iter().flat_map(|part| part.kinds)
}
