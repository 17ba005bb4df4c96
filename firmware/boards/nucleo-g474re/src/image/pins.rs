//! The pins: `docs/board.md` lists their uses. RM0440 9.4: GPIOx_MODER (9.4.1), PUPDR (9.4.4), IDR (9.4.5), BSRR (9.4.7), AFRL and
//! AFRH (9.4.9, 9.4.10); the numbers of the alternate functions are those of DS12288, table of alternate functions.

use stm32_metapac::gpio::Gpio;
use stm32_metapac::gpio::vals::{Idr, Moder, Pupdr};

/// A pin of a port.
#[derive(Clone, Copy)]
pub struct Pin {
    port: Gpio,
    number: usize,
}

impl Pin {
    /// A pin.
    pub const fn new(port: Gpio, number: usize) -> Self {
        Pin { port, number }
    }

    /// Gives the pin to a peripheral.
    pub fn alternate(self, function: u8, pull: Pupdr) {
        self.port.afr(self.number / 8).modify(|w| w.set_afr(self.number % 8, function));
        self.mode(Moder::ALTERNATE, pull);
    }

    /// Gives the pin to the converters.
    pub fn analog(self) {
        self.mode(Moder::ANALOG, Pupdr::FLOATING);
    }

    /// Makes the pin an input.
    pub fn input(self, pull: Pupdr) {
        self.mode(Moder::INPUT, pull);
    }

    /// Makes the pin an output, low.
    pub fn output(self) {
        self.set(false);
        self.mode(Moder::OUTPUT, Pupdr::FLOATING);
    }

    /// Sets an output.
    pub fn set(self, high: bool) {
        self.port.bsrr().write(|w| if high { w.set_bs(self.number, true) } else { w.set_br(self.number, true) });
    }

    /// The level of the pin, also of one that the part drives.
    pub fn is_high(self) -> bool {
        self.port.idr().read().idr(self.number) == Idr::HIGH
    }

    fn mode(self, mode: Moder, pull: Pupdr) {
        self.port.pupdr().modify(|w| w.set_pupdr(self.number, pull));
        self.port.moder().modify(|w| w.set_moder(self.number, mode));
    }
}
