//! What fails between the controller and the transducer.

use super::super::injected::Failure;
use super::{Kind, SENSE, SENSE_MS, SENSE_OR_LIMIT};

/// Lanes other than the first are listened to one after the other, ms.
const LANES_MS: f64 = 40.0;

/// DAC.
pub(super) const DAC: &[Kind] = &[
    Kind {
        name: "DAC repeats",
        what: "the DAC plays the same block for ever",
        draw: |_| Failure::Repeats,
        named: SENSE_OR_LIMIT,
        off_ms: Some(SENSE_MS),
    },
    Kind { name: "DAC holds", what: "the DAC stays at its code", draw: |_| Failure::Holds, named: SENSE, off_ms: Some(SENSE_MS) },
    Kind {
        name: "DAC bit",
        what: "one of the bits 4 to 11 of the DAC stays low or high",
        draw: |random| Failure::DacBit(random.whole(4, 11) as u8, random.toss()),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
];

/// Amplifier.
pub(super) const AMPLIFIER: &[Kind] = &[
    Kind {
        name: "amplifier loud",
        what: "the amplifier plays 1.25 to 2 times its voltage",
        draw: |random| Failure::Amplifier(random.between(1.25, 2.0)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "amplifier weak",
        what: "the amplifier plays 0.3 to 0.8 of its voltage",
        draw: |random| Failure::Amplifier(random.between(0.3, 0.8)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "amplifier dead",
        what: "the amplifier plays nothing",
        draw: |_| Failure::Dead,
        named: SENSE,
        off_ms: Some(SENSE_MS),
    },
    Kind {
        name: "half wave",
        what: "the amplifier plays one half wave only",
        draw: |_| Failure::HalfWave,
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "amplifier clips",
        what: "the amplifier clips at 0.3 to 0.8 of the drive",
        draw: |random| Failure::Clips(random.between(0.3, 0.8)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "amplifier slow",
        what: "the amplifier follows by 0.05 to 0.3 of the drive a sample at most",
        draw: |random| Failure::Slews(random.between(0.05, 0.3)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "supply ripples",
        what: "the amplifier's gain ripples by 10 to 40 %, with a period of 100 to 400 blocks",
        draw: |random| Failure::Ripples(random.between(0.1, 0.4), random.whole(100, 400)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "amplifier drifts",
        what: "the amplifier's gain rises to 1.4 to 3 times what it was within 10 to 30 ms",
        draw: |random| Failure::Drifts(random.between(1.4, 3.0), random.whole(300, 900)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
];

/// Lanes 1 to 3.
pub(super) const LANES: &[Kind] = &[
    Kind {
        name: "lane open",
        what: "the electrodes of lane 1, 2 or 3 are not connected",
        draw: |random| Failure::Lane("lane_open", random.whole(1, 3) as u8),
        named: &[29],
        off_ms: Some(LANES_MS),
    },
    Kind {
        name: "lane weak",
        what: "the amplifier of lane 1, 2 or 3 plays half of its voltage",
        draw: |random| Failure::Lane("lane_weak", random.whole(1, 3) as u8),
        named: &[24],
        off_ms: Some(LANES_MS),
    },
    Kind {
        name: "lane reversed",
        what: "the amplifier of lane 1, 2 or 3 plays the opposite",
        draw: |random| Failure::Lane("lane_reversed", random.whole(1, 3) as u8),
        named: &[24],
        off_ms: Some(LANES_MS),
    },
    Kind {
        name: "lanes exchanged",
        what: "the inputs of lanes 1 and 2, or 2 and 3, are exchanged",
        draw: |random| Failure::Lane("lanes_exchanged", random.whole(1, 2) as u8),
        named: &[24],
        off_ms: Some(LANES_MS),
    },
];
