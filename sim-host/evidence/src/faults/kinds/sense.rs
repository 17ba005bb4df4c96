//! Failures between the transducer and the controller.

use super::super::injected::{Channel, Failure};
use super::{Kind, SENSE_OR_LIMIT, breakdown, doubtful, harmless, reported};
use crate::random::Random;

/// Lists the failures of a sense channel.
macro_rules! channel {
    ($channel:expr, $name:literal) => {
        &[
            doubtful(concat!($name, " gain low"), concat!("the ", $name, " channel reads 0.3 to 0.8 of the ", $name), |random| {
                Failure::Gain($channel, random.between(0.3, 0.8))
            }),
            doubtful(
                concat!($name, " gain high"),
                concat!("the ", $name, " channel reads 1.25 to 3 times the ", $name),
                |random| Failure::Gain($channel, random.between(1.25, 3.0)),
            ),
            breakdown(concat!($name, " reversed"), concat!("the polarity of the ", $name, " channel is reversed"), |_| {
                Failure::Gain($channel, -1.0)
            }),
            doubtful(concat!($name, " offset"), concat!("the ", $name, " channel is offset by 200 to 1500 codes"), |random| {
                Failure::Offset($channel, offset(random))
            }),
            breakdown(concat!($name, " stuck"), concat!("the ", $name, " channel returns one code, any of 4096"), |random| {
                Failure::Stuck($channel, random.whole(0, 4095) as u16)
            }),
            doubtful(
                concat!($name, " bit"),
                concat!("one of the bits 4 to 11 of the ", $name, " channel is stuck low or high"),
                |random| Failure::Bit($channel, random.whole(4, 11) as u8, random.toss()),
            ),
            doubtful(concat!($name, " late"), concat!("the ", $name, " channel is 1 to 12 samples late"), |random| {
                Failure::Late($channel, random.whole(1, 12) as usize)
            }),
            doubtful(
                concat!($name, " noise"),
                concat!("the ", $name, " channel has noise of 20 to 300 codes to either side"),
                |random| Failure::Noise($channel, random.whole(20, 300) as u16),
            ),
            harmless(
                concat!($name, " spike"),
                concat!("one sample of the ", $name, " channel is at the end of its range"),
                |_| Failure::Spike($channel),
            ),
        ]
    };
}

/// Failures of the current channel.
pub(super) const CURRENT: &[Kind] = channel!(Channel::Current, "current");

/// Failures of the voltage channel.
pub(super) const VOLTAGE: &[Kind] = channel!(Channel::Voltage, "voltage");

/// Failures of the converters.
pub(super) const CONVERTERS: &[Kind] = &[
    // If both have the same codes in the same phase, as at a resonance, it has no effect until the
    // drive changes.
    Kind { off_ms: None, ..breakdown("channels exchanged", "voltage and current are exchanged", |_| Failure::Exchanged) },
    Kind {
        named: SENSE_OR_LIMIT,
        ..breakdown("converters stale", "the converters return the same block forever", |_| Failure::Stale)
    },
    harmless("one block stale", "the converters return one block twice", |_| Failure::StaleOnce),
    doubtful("halves exchanged", "each half of the sense buffer is read a block late", |_| Failure::Halves),
    reported("range ends", &[21, 28], "both channels read the end of their range", |_| Failure::Scene("saturation")),
    reported("block lost", &[11], "a block arrives without codes", |_| Failure::Scene("dropout")),
    reported("block late", &[11], "a block is delivered late", |_| Failure::Scene("late_block")),
];

/// Draws an offset of a channel, codes.
fn offset(random: &mut Random) -> i32 {
    let codes = random.whole(200, 1500) as i32;
    if random.toss() { -codes } else { codes }
}
