//! What fails, and what is promised of it.

use super::injected::{Channel, Failure};
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

use Channel::{Current, Voltage};

/// The sense chain says something that is not so: implausible (in a motor: of a lane), open, saturated, too much, swapped, disagreeing, another mode; or the lock is lost by it.
const SENSE: &[u8] = &[20, 21, 23, 24, 25, 26, 27, 28, 31, 32, 33, 34];
/// The same, and the limits that say that the lock is in doubt.
const SENSE_OR_LIMIT: &[u8] = &[20, 21, 23, 24, 25, 26, 27, 28, 31, 32, 33, 34, 97, 98, 107];
/// A sense chain that breaks down is off within this time, ms.
const SENSE_MS: f64 = 5.0;
/// What the hardware reports, ms.
const REPORTED_MS: f64 = 0.1;

/// All kinds.
pub(super) const KINDS: [Kind; 40] = [
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
        name: "current reversed",
        what: "the current channel reads the opposite",
        draw: |_| Failure::Gain(Current, -1.0),
        named: SENSE,
        off_ms: Some(SENSE_MS),
    },
    Kind {
        name: "voltage reversed",
        what: "the voltage channel reads the opposite",
        draw: |_| Failure::Gain(Voltage, -1.0),
        named: SENSE,
        off_ms: Some(SENSE_MS),
    },
    Kind {
        name: "channels exchanged",
        what: "voltage and current are exchanged",
        draw: |_| Failure::Exchanged,
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
        name: "voltage offset",
        what: "the voltage channel is offset by 200 to 1500 codes",
        draw: |random| Failure::Offset(Voltage, offset(random)),
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
        name: "voltage stuck",
        what: "the voltage channel gives one code, any of 4096",
        draw: |random| Failure::Stuck(Voltage, random.whole(0, 4095) as u16),
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
        name: "voltage bit",
        what: "one of the bits 4 to 11 of the voltage channel stays low or high",
        draw: |random| Failure::Bit(Voltage, random.whole(4, 11) as u8, random.toss()),
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
        name: "voltage late",
        what: "the voltage channel is 1 to 12 samples late",
        draw: |random| Failure::Late(Voltage, random.whole(1, 12) as usize),
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
        name: "voltage noise",
        what: "the voltage channel has noise of 20 to 300 codes to either side",
        draw: |random| Failure::Noise(Voltage, random.whole(20, 300) as u16),
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
    Kind {
        name: "voltage spike",
        what: "one sample of the voltage channel is at the end of its range",
        draw: |_| Failure::Spike(Voltage),
        named: &[],
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
        name: "stack shorted",
        what: "50 milliohm across the stack",
        draw: |_| Failure::Scene("short"),
        named: &[20, 21, 22, 28],
        off_ms: Some(REPORTED_MS),
    },
    Kind {
        name: "current lead open",
        what: "the current channel reads nothing",
        draw: |_| Failure::Scene("open"),
        named: &[20, 23],
        off_ms: Some(SENSE_MS),
    },
    Kind {
        name: "stack depoled",
        what: "C0 falls by a third, the coupling to a tenth",
        draw: |_| Failure::Scene("depoled"),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "stack cracked",
        what: "Q falls to a fifth, a second mode appears",
        draw: |_| Failure::Scene("cracked"),
        named: SENSE_OR_LIMIT,
        off_ms: None,
    },
    Kind {
        name: "host lost",
        what: "the host says nothing",
        draw: |_| Failure::HostLost,
        named: &[12],
        off_ms: Some(REPORTED_MS),
    },
    Kind {
        name: "emergency stop",
        what: "the stop is pressed",
        draw: |_| Failure::EmergencyStop,
        named: &[10],
        off_ms: Some(REPORTED_MS),
    },
    Kind {
        name: "comparator fires",
        what: "the hardware reports too much current",
        draw: |_| Failure::Comparator,
        named: &[21],
        off_ms: Some(REPORTED_MS),
    },
    Kind {
        name: "amplifier fault",
        what: "the amplifier says that it has failed, or its supply is outside its window",
        draw: |random| if random.toss() { Failure::AmplifierSays } else { Failure::Supply },
        named: &[13, 14],
        off_ms: Some(REPORTED_MS),
    },
];

/// Codes by which a channel is offset.
fn offset(random: &mut Random) -> i32 {
    let codes = random.whole(200, 1500) as i32;
    if random.toss() { -codes } else { codes }
}
