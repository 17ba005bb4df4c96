//! Failures between the controller and the transducer.

use super::super::injected::Failure;
use super::{Kind, SENSE_OR_LIMIT, breakdown, doubtful};
use crate::random::Random;

/// Time until the drive is off after a failure of lanes 1 to 3, which are measured in turn, ms.
const LANES_MS: f64 = 40.0;

/// Creates a failure of a lane, which is detected when the lane is measured.
const fn lane(name: &'static str, named: &'static [u8], what: &'static str, draw: fn(&mut Random) -> Failure) -> Kind {
    Kind { name, what, draw, named, off_ms: Some(LANES_MS) }
}

/// Failures of the DAC.
pub(super) const DAC: &[Kind] = &[
    Kind { named: SENSE_OR_LIMIT, ..breakdown("DAC repeats", "the DAC plays the same block forever", |_| Failure::Repeats) },
    breakdown("DAC holds", "the DAC holds its code", |_| Failure::Holds),
    doubtful("DAC bit", "one of the bits 4 to 11 of the DAC is stuck low or high", |random| {
        Failure::DacBit(random.whole(4, 11) as u8, random.toss())
    }),
];

/// Failures of the amplifier.
pub(super) const AMPLIFIER: &[Kind] = &[
    doubtful("amplifier loud", "the amplifier plays 1.25 to 2 times its voltage", |random| {
        Failure::Amplifier(random.between(1.25, 2.0))
    }),
    doubtful("amplifier weak", "the amplifier plays 0.3 to 0.8 of its voltage", |random| {
        Failure::Amplifier(random.between(0.3, 0.8))
    }),
    breakdown("amplifier dead", "the amplifier plays nothing", |_| Failure::Dead),
    doubtful("half wave", "the amplifier plays only one half wave", |_| Failure::HalfWave),
    doubtful("amplifier clips", "the amplifier clips at 0.3 to 0.8 of the drive", |random| {
        Failure::Clips(random.between(0.3, 0.8))
    }),
    doubtful("amplifier slow", "the output of the amplifier changes by at most 0.05 to 0.3 of the drive per sample", |random| {
        Failure::Slews(random.between(0.05, 0.3))
    }),
    doubtful("supply ripples", "the amplifier's gain ripples by 10 to 40 %, with a period of 100 to 400 blocks", |random| {
        Failure::Ripples(random.between(0.1, 0.4), random.whole(100, 400))
    }),
    doubtful("amplifier drifts", "the amplifier's gain rises to 1.4 to 3 times its value within 10 to 30 ms", |random| {
        Failure::Drifts(random.between(1.4, 3.0), random.whole(300, 900))
    }),
];

/// Failures of lanes 1 to 3.
pub(super) const LANES: &[Kind] = &[
    lane("lane open", &[29], "the electrodes of lane 1, 2 or 3 are not connected", |random| {
        Failure::Lane("lane_open", random.whole(1, 3) as u8)
    }),
    lane("lane weak", &[24], "the amplifier of lane 1, 2 or 3 plays half of its voltage", |random| {
        Failure::Lane("lane_weak", random.whole(1, 3) as u8)
    }),
    lane("lane reversed", &[24], "the polarity of the amplifier of lane 1, 2 or 3 is reversed", |random| {
        Failure::Lane("lane_reversed", random.whole(1, 3) as u8)
    }),
    lane("lanes exchanged", &[24], "the inputs of lanes 1 and 2, or 2 and 3, are exchanged", |random| {
        Failure::Lane("lanes_exchanged", random.whole(1, 2) as u8)
    }),
];
