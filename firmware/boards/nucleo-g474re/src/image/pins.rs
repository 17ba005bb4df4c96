//! Pins of the processor: `docs/board.md` lists their uses. RM0440 9.4: GPIOx_MODER (9.4.1), PUPDR
//! (9.4.4), IDR (9.4.5), BSRR (9.4.7), AFRL and AFRH (9.4.9, 9.4.10). DS12288 has the table of the
//! alternate functions.

use stm32_metapac::gpio::Gpio;
use stm32_metapac::gpio::vals::{Idr, Moder, Pupdr};

/// Pin of a port.
#[derive(Clone, Copy)]
pub struct Pin {
    port: Gpio,
    number: usize,
}

impl Pin {
    /// Creates a pin from its port and number.
    pub const fn new(port: Gpio, number: usize) -> Self {
        Pin { port, number }
    }

    /// Connects the pin to a peripheral.
    pub fn alternate(self, function: u8, pull: Pupdr) {
        self.port.afr(self.number / 8).modify(|w| w.set_afr(self.number % 8, function));
        self.mode(Moder::ALTERNATE, pull);
    }

    /// Connects the pin to the converters.
    pub fn analog(self) {
        self.mode(Moder::ANALOG, Pupdr::FLOATING);
    }

    /// Makes the pin an input with this pull.
    pub fn input(self, pull: Pupdr) {
        self.mode(Moder::INPUT, pull);
    }

    /// Makes the pin an output and sets it low.
    pub fn output(self) {
        self.set(false);
        self.mode(Moder::OUTPUT, Pupdr::FLOATING);
    }

    /// Sets the level of an output.
    pub fn set(self, high: bool) {
        self.port.bsrr().write(|w| if high { w.set_bs(self.number, true) } else { w.set_br(self.number, true) });
    }

    /// Returns `true` if the level of the pin is high. Also works for a pin that the processor
    /// drives.
    pub fn is_high(self) -> bool {
        self.port.idr().read().idr(self.number) == Idr::HIGH
    }

    fn mode(self, mode: Moder, pull: Pupdr) {
        self.port.pupdr().modify(|w| w.set_pupdr(self.number, pull));
        self.port.moder().modify(|w| w.set_moder(self.number, mode));
    }
}
