//! What hangs on the pins.

use std::fmt;

use cortex_m4::Cycle;

/// A pin: port `A` is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin {
    /// The port, 0 for `A`.
    pub port: u8,
    /// The number of the pin within its port.
    pub number: u8,
}

impl Pin {
    /// The pin `port` (a letter, `'A'`) and `number`.
    pub const fn new(port: char, number: u8) -> Self {
        Pin { port: port as u8 - b'A', number }
    }

    /// The pin of a name such as `PA10`.
    pub(crate) fn named(name: &str) -> Option<Self> {
        let port = name.strip_prefix('P')?.chars().next()?;
        Some(Pin::new(port, name.get(2..)?.parse().ok()?))
    }
}

impl fmt::Display for Pin {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "P{}{}", char::from(b'A' + self.port), self.number)
    }
}

/// What a pin of the part does to its wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The part pulls it low.
    Low,
    /// The part pulls it high.
    High,
    /// The part leaves it alone; a resistor outside decides.
    Floating,
}

/// What the wires do to the pins of a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drive {
    /// Pins that are driven, a bit each. The others follow the part's pulls.
    pub driven: u16,
    /// Levels of those.
    pub high: u16,
}

/// A byte on the receiver's line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Received {
    /// The byte.
    pub byte: u8,
    /// Its stop bit was low: framing error.
    pub framing: bool,
    /// Its samples disagreed: noise error.
    pub noise: bool,
}

/// The board around the part. Times are in cycles of the core clock; each call has a time that is not before that of the call before it.
///
/// A board that changes an input by itself says when, by [`due`](Wires::due); the part asks for it again after every call.
pub trait Wires {
    /// DAC `dac` (1 to 4) puts out other codes of 12 bits on its two channels: by a trigger of a timer, or because the
    /// program has written them or has switched a channel.
    fn dac(&mut self, at: Cycle, dac: u8, codes: [u16; 2], triggered: bool);

    /// The voltage of an analog pin, V.
    fn volts(&mut self, at: Cycle, pin: Pin) -> f64;

    /// Temperature of the die, °C: what the sensor at ADC1 and ADC5 measures.
    fn celsius(&mut self, _at: Cycle) -> f64 {
        30.0
    }

    /// A digital output changes.
    fn output(&mut self, at: Cycle, pin: Pin, level: Level);

    /// Levels of the pins of a port, 0 for `A`.
    fn inputs(&mut self, _at: Cycle, _port: u8) -> Drive {
        Drive::default()
    }

    /// Position of the encoder at TIM5's channels 1 and 2, in edges of both channels (4 a period); up when channel 1 leads.
    fn encoder(&mut self, _at: Cycle) -> i32 {
        0
    }

    /// When a digital input or the voltage at a comparator next changes by itself: the part then looks at all of them.
    fn due(&self) -> Cycle {
        Cycle::MAX
    }

    /// When the next byte's start bit comes; the part waits until the byte before it has ended.
    fn byte_due(&self) -> Cycle {
        Cycle::MAX
    }

    /// The byte whose start bit came at `at`: called at its end. None: there was no byte after all.
    fn receive(&mut self, _at: Cycle) -> Option<Received> {
        None
    }

    /// The part is reset; `flags` is RCC_CSR as the program finds it (RM0440 7.4.28).
    fn reset(&mut self, _at: Cycle, _flags: u32) {}

    /// The transmitter has sent a byte; its stop bit ends at `at`.
    fn sent(&mut self, _at: Cycle, _byte: u8) {}
}

/// A board with nothing on it: inputs float, analog pins are at half the supply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bare;

impl Wires for Bare {
    fn dac(&mut self, _at: Cycle, _dac: u8, _codes: [u16; 2], _triggered: bool) {}

    fn volts(&mut self, _at: Cycle, _pin: Pin) -> f64 {
        1.65
    }

    fn output(&mut self, _at: Cycle, _pin: Pin, _level: Level) {}
}
