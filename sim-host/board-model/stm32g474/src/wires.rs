//! Interface between the microcontroller and the board at its pins.

use std::fmt;

use cortex_m4::Cycle;

/// Pin of the microcontroller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin {
    /// Port, 0 for `A`.
    pub port: u8,
    /// Number of the pin within its port.
    pub number: u8,
}

impl Pin {
    /// Creates a pin from a letter, such as `'A'`, and a number.
    pub const fn new(port: char, number: u8) -> Self {
        Pin { port: port as u8 - b'A', number }
    }

    /// Parses a name such as `PA10`.
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

/// Output of a pin to its wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Driven low.
    Low,
    /// Driven high.
    High,
    /// Not driven; an external resistor decides.
    Floating,
}

/// Signals of the wires at the pins of a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drive {
    /// Driven pins, one bit each. The others follow the pulls of the microcontroller.
    pub driven: u16,
    /// Levels of the driven pins.
    pub high: u16,
}

/// Byte on the line to the receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Received {
    /// Value of the byte.
    pub byte: u8,
    /// `true` if its stop bit was low: framing error.
    pub framing: bool,
    /// `true` if its samples disagreed: noise error.
    pub noise: bool,
}

/// Board around the microcontroller. Times are in cycles of the core clock, and never decrease from
/// call to call.
///
/// A board that changes an input without a call returns the cycle by [`due`](Wires::due), which is
/// read again after every call.
pub trait Wires {
    /// Outputs other codes of 12 bits at the two channels of DAC `dac` (1 to 4). `triggered` is
    /// `true` for a trigger of a timer, and `false` if the program has written the codes or
    /// switched a channel.
    fn dac(&mut self, at: Cycle, dac: u8, codes: [u16; 2], triggered: bool);

    /// Returns the voltage of an analog pin, V.
    fn volts(&mut self, at: Cycle, pin: Pin) -> f64;

    /// Returns the temperature of the die, °C, which the sensor at ADC1 and ADC5 measures.
    fn celsius(&mut self, _at: Cycle) -> f64 {
        30.0
    }

    /// Reports a change of a digital output.
    fn output(&mut self, at: Cycle, pin: Pin, level: Level);

    /// Returns the levels of the pins of a port, 0 for `A`.
    fn inputs(&mut self, _at: Cycle, _port: u8) -> Drive {
        Drive::default()
    }

    /// Returns the position of the encoder at channels 1 and 2 of TIM5, in edges of both channels
    /// (4 per period); it increases when channel 1 leads.
    fn encoder(&mut self, _at: Cycle) -> i32 {
        0
    }

    /// Returns the cycle at which a digital input or the voltage at a comparator next changes
    /// without a call; the microcontroller then reads all of them.
    fn due(&self) -> Cycle {
        Cycle::MAX
    }

    /// Returns the cycle of the next byte's start bit. The byte is delayed until the previous one
    /// has ended.
    fn byte_due(&self) -> Cycle {
        Cycle::MAX
    }

    /// Returns the byte whose start bit came at `at`, at its end. `None`: there was no byte.
    fn receive(&mut self, _at: Cycle) -> Option<Received> {
        None
    }

    /// Reports a reset; `flags` is RCC_CSR as the program reads it (RM0440 7.4.28).
    fn reset(&mut self, _at: Cycle, _flags: u32) {}

    /// Reports a byte of the transmitter; its stop bit ends at `at`.
    fn sent(&mut self, _at: Cycle, _byte: u8) {}
}

/// Board without any circuit: inputs float, analog pins are at half the supply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bare;

impl Wires for Bare {
    fn dac(&mut self, _at: Cycle, _dac: u8, _codes: [u16; 2], _triggered: bool) {}

    fn volts(&mut self, _at: Cycle, _pin: Pin) -> f64 {
        1.65
    }

    fn output(&mut self, _at: Cycle, _pin: Pin, _level: Level) {}
}
