//! Kinds of failures, with the response promised for each.

mod around;
mod drive;
mod sense;

use super::injected::Failure;
use crate::random::Random;

/// A kind of failure.
pub(super) struct Kind {
    /// Name in tables.
    pub(super) name: &'static str,
    /// Description of the failure, with its range.
    pub(super) what: &'static str,
    /// Draws a failure of the kind.
    pub(super) draw: fn(&mut Random) -> Failure,
    /// Faults and limits that are correct reports; empty if the failure is harmless.
    pub(super) named: &'static [u8],
    /// Promised time until the drive is off, ms; `None` if none is promised.
    pub(super) off_ms: Option<f64>,
}

/// Faults that report a wrong sense chain: implausible (in a motor: in a lane), open, saturated,
/// over-current, swapped, disagreeing, another mode; or a lock that is lost because of it.
const SENSE: &[u8] = &[20, 21, 23, 24, 25, 26, 27, 28, 31, 32, 33, 34];
/// The codes of [`SENSE`], and the limits that report a doubtful lock.
const SENSE_OR_LIMIT: &[u8] = &[20, 21, 23, 24, 25, 26, 27, 28, 31, 32, 33, 34, 97, 98, 107];
/// Time until the drive is off after a breakdown of the sense chain, ms.
const SENSE_MS: f64 = 5.0;
/// Time until the drive is off after a report of the hardware, ms.
const REPORTED_MS: f64 = 0.1;

/// Creates a failure that a fault or a limit of a doubtful lock may report.
const fn doubtful(name: &'static str, what: &'static str, draw: fn(&mut Random) -> Failure) -> Kind {
    Kind { name, what, draw, named: SENSE_OR_LIMIT, off_ms: None }
}

/// Creates a breakdown of the sense chain, which must end the drive.
const fn breakdown(name: &'static str, what: &'static str, draw: fn(&mut Random) -> Failure) -> Kind {
    Kind { name, what, draw, named: SENSE, off_ms: Some(SENSE_MS) }
}

/// Creates a failure that one of these faults must report at once.
const fn reported(name: &'static str, named: &'static [u8], what: &'static str, draw: fn(&mut Random) -> Failure) -> Kind {
    Kind { name, what, draw, named, off_ms: Some(REPORTED_MS) }
}

/// Creates a change that no fault may report.
const fn harmless(name: &'static str, what: &'static str, draw: fn(&mut Random) -> Failure) -> Kind {
    Kind { name, what, draw, named: &[], off_ms: None }
}

/// A part of the system, with the kinds of its failures.
pub(super) struct Part {
    /// Name in tables.
    pub(super) name: &'static str,
    /// All its kinds.
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

/// Returns all kinds, part by part.
pub(super) fn all() -> impl Iterator<Item = &'static Kind> {
    PARTS.iter().flat_map(|part| part.kinds)
}
