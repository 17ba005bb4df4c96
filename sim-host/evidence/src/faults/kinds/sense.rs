//! What fails between the transducer and the controller.

use super::super::injected::{Channel, Failure};
use super::{Kind, REPORTED_MS, SENSE, SENSE_MS, SENSE_OR_LIMIT};
use crate::random::Random;

use Channel::{Current, Voltage};

/// Current channel.
pub(super) const CURRENT: &[Kind] = &[
    Kind {
        name: "current gain low",
        what: "the current channel reads 0.3 to 0.8 of the current",
        draw: |random| Failure::Gain(Current, random.between(0.3, 0.8)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "current gain high",
        what: "the current channel reads 1.25 to 3 times the current",
        draw: |random| Failure::Gain(Current, random.between(1.25, 3.0)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "current reversed",
        what: "the current channel reads the opposite",
        draw: |_| Failure::Gain(Current, -1.0),
        named: SENSE,
        off_ms: Some(SENSE_MS),
    },
    Kind {
        name: "current offset",
        what: "the current channel is offset by 200 to 1500 codes",
        draw: |random| Failure::Offset(Current, offset(random)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "current stuck",
        what: "the current channel gives one code, any of 4096",
        draw: |random| Failure::Stuck(Current, random.whole(0, 4095) as u16),
        named: SENSE,
        off_ms: Some(SENSE_MS),
    },
    Kind {
        name: "current bit",
        what: "one of the bits 4 to 11 of the current channel stays low or high",
        draw: |random| Failure::Bit(Current, random.whole(4, 11) as u8, random.toss()),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "current late",
        what: "the current channel is 1 to 12 samples late",
        draw: |random| Failure::Late(Current, random.whole(1, 12) as usize),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "current noise",
        what: "the current channel has noise of 20 to 300 codes to either side",
        draw: |random| Failure::Noise(Current, random.whole(20, 300) as u16),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "current spike",
        what: "one sample of the current channel is at the end of its range",
        draw: |_| Failure::Spike(Current),
        named: &[],
        off_ms: None,
    },
];

/// Voltage channel.
pub(super) const VOLTAGE: &[Kind] = &[
    Kind {
        name: "voltage gain low",
        what: "the voltage channel reads 0.3 to 0.8 of the voltage",
        draw: |random| Failure::Gain(Voltage, random.between(0.3, 0.8)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "voltage gain high",
        what: "the voltage channel reads 1.25 to 3 times the voltage",
        draw: |random| Failure::Gain(Voltage, random.between(1.25, 3.0)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "voltage reversed",
        what: "the voltage channel reads the opposite",
        draw: |_| Failure::Gain(Voltage, -1.0),
        named: SENSE,
        off_ms: Some(SENSE_MS),
    },
    Kind {
        name: "voltage offset",
        what: "the voltage channel is offset by 200 to 1500 codes",
        draw: |random| Failure::Offset(Voltage, offset(random)),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "voltage stuck",
        what: "the voltage channel gives one code, any of 4096",
        draw: |random| Failure::Stuck(Voltage, random.whole(0, 4095) as u16),
        named: SENSE,
        off_ms: Some(SENSE_MS),
    },
    Kind {
        name: "voltage bit",
        what: "one of the bits 4 to 11 of the voltage channel stays low or high",
        draw: |random| Failure::Bit(Voltage, random.whole(4, 11) as u8, random.toss()),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "voltage late",
        what: "the voltage channel is 1 to 12 samples late",
        draw: |random| Failure::Late(Voltage, random.whole(1, 12) as usize),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "voltage noise",
        what: "the voltage channel has noise of 20 to 300 codes to either side",
        draw: |random| Failure::Noise(Voltage, random.whole(20, 300) as u16),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "voltage spike",
        what: "one sample of the voltage channel is at the end of its range",
        draw: |_| Failure::Spike(Voltage),
        named: &[],
        off_ms: None,
    },
];

/// Converters.
pub(super) const CONVERTERS: &[Kind] = &[
    Kind {
        name: "channels exchanged",
        what: "voltage and current are exchanged",
        // Where both have the same codes in the same phase, as at a resonance, nothing shows before the drive moves.
        draw: |_| Failure::Exchanged,
        named: SENSE,
        off_ms: None,
    },
    Kind {
        name: "converters stale",
        what: "the converters give the same block for ever",
        draw: |_| Failure::Stale,
        named: SENSE_OR_LIMIT,
        off_ms: Some(SENSE_MS),
    },
    Kind {
        name: "one block stale",
        what: "the converters give one block twice",
        draw: |_| Failure::StaleOnce,
        named: &[],
        off_ms: None,
    },
    Kind {
        name: "halves exchanged",
        what: "each half of the sense buffer is read a block late",
        draw: |_| Failure::Halves,
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "range ends",
        what: "both channels read the end of their range",
        draw: |_| Failure::Scene("saturation"),
        named: &[21, 28],
        off_ms: Some(REPORTED_MS),
    },
    Kind {
        name: "block lost",
        what: "a block arrives without codes",
        draw: |_| Failure::Scene("dropout"),
        named: &[11],
        off_ms: Some(REPORTED_MS),
    },
    Kind {
        name: "block late",
        what: "a block is delivered late",
        draw: |_| Failure::Scene("late_block"),
        named: &[11],
        off_ms: Some(REPORTED_MS),
    },
];

/// Codes by which a channel is offset.
fn offset(random: &mut Random) -> i32 {
    let codes = random.whole(200, 1500) as i32;
    if random.toss() { -codes } else { codes }
}
