//! Cause of the last start: the reset flags, and the record that the last run has left.

use heapless::String;
use serde::{Deserialize, Serialize};

/// Length of the longest stored end of a file name, bytes.
pub const NAME: usize = 40;

/// Cause of the last start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Start {
    /// Power-on, or an unknown cause.
    #[default]
    PowerOn,
    /// A low level at the reset pin.
    Pin,
    /// An order of the host to reset.
    Ordered,
    /// The watchdog: the block stream or the background task had stopped.
    Watchdog,
    /// A panic, at this line of the source.
    Panic(Place),
    /// A hard fault, at this address of the code.
    HardFault(u32),
    /// An interrupt without a handler, with its number.
    Unexpected(u32),
    /// DMA or a converter had lost a sample, after this number of blocks.
    StreamLost(u32),
    /// A word of the code or of its constants could not be read, at this address.
    DamagedCode(u32),
    /// The crystal had stopped; the board runs from its internal oscillator until the next reset.
    ClockFailed,
    /// The stack had grown into its guard; the code was at this address.
    StackOverflow(u32),
    /// The supply had fallen below the level of its detector.
    SupplyLow,
    /// A word of the RAM had a wrong parity bit.
    RamParity,
    /// The over-current trips have failed their test after this start, for any cause: the
    /// amplifier stays off until the next reset.
    TripFailed(TripFailure),
    /// The microcontroller has this silicon revision, with an erratum that this firmware does not
    /// handle: the amplifier stays off.
    UnsupportedSilicon(u16),
}

/// Failure of the test of the over-current trips, with the amplifier off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TripFailure {
    /// The current is not at the middle of its range: the current channel is offset or not
    /// connected.
    NotAtRest,
    /// The two inputs of the trips do not show the same current: the wire to the negative one is
    /// missing.
    Wire,
    /// The positive trip does not act when its threshold is moved below the current.
    NoPositive,
    /// The negative trip does not act when its threshold is moved above the current.
    NoNegative,
    /// A trip acts although the current is within both thresholds.
    Standing,
}

/// A line of a source file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// End of the file name.
    pub file: FileName,
    /// Number of the line.
    pub line: u32,
}

/// End of a file name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String<NAME>", from = "String<NAME>")]
pub struct FileName {
    length: u8,
    bytes: [u8; NAME],
}

impl FileName {
    /// Takes the longest end of a name that fits, from a whole character on.
    pub fn of(name: &str) -> Self {
        let first = (0..=name.len()).find(|&first| name.len() - first <= NAME && name.is_char_boundary(first));
        let end = first.and_then(|first| name.get(first..)).unwrap_or_default();
        let mut bytes = [0; NAME];
        bytes.iter_mut().zip(end.bytes()).for_each(|(to, from)| *to = from);
        FileName { length: end.len() as u8, bytes }
    }

    /// Returns the name as text.
    pub fn as_str(&self) -> &str {
        self.bytes.get(..self.length.into()).and_then(|bytes| core::str::from_utf8(bytes).ok()).unwrap_or("?")
    }
}

impl From<FileName> for String<NAME> {
    fn from(name: FileName) -> Self {
        String::try_from(name.as_str()).unwrap_or_default()
    }
}

impl From<String<NAME>> for FileName {
    fn from(name: String<NAME>) -> Self {
        FileName::of(&name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_a_long_name_is_kept_and_no_character_is_cut() {
        assert_eq!(FileName::of("src/main.rs").as_str(), "src/main.rs");
        let long = "a/very/long/path/to/".repeat(3) + "main.rs";
        assert_eq!(FileName::of(&long).as_str(), &long[long.len() - NAME..]);
        // 41 bytes, of which the first two are one character.
        let accented = std::format!("\u{e9}{}", "x".repeat(39));
        assert_eq!(FileName::of(&accented).as_str(), "x".repeat(39));
        assert_eq!(FileName::of("").as_str(), "");
    }

    #[test]
    fn a_start_round_trips_through_the_link() {
        let start = Start::Panic(Place { file: FileName::of("firmware/src/controller.rs"), line: 311 });
        let mut buffer = [0; 64];
        let bytes = postcard::to_slice(&start, &mut buffer).unwrap();
        assert_eq!(postcard::from_bytes::<Start>(bytes), Ok(start));
    }
}
