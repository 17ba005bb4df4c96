//! The link: LPUART1 on PA2 and PA3, which the Nucleo's ST-LINK shows the host as a serial port (UM2505). 921 600 baud, 8N1. RM0440 38.
//!
//! Bytes come by DMA into a ring, so that none is lost while the background task does something else for up to 5 ms; they leave through the transmitter's
//! buffer of eight, one at each poll. Nothing here waits but a flush, before a reset.

use core::convert::Infallible;

use boards_common::position::position;
use boards_common::reader::Reader;
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use nucleo_g474re::baud::divider;
use stm32_metapac::bdma::vals::Pl;
use stm32_metapac::gpio::vals::Pupdr;
use stm32_metapac::usart::regs::Brr;
use stm32_metapac::{GPIOA, LPUART1};

use super::clocks::SYSTEM_HZ;
use super::dma::{Channel, Ring, Way};
use super::pins::Pin;

/// Speed of the link, bits a second.
pub const BAUD: u32 = 921_600;
/// What divides the clock.
const DIVIDER: u32 = match divider(SYSTEM_HZ, BAUD) {
    Some(divider) => divider,
    None => panic!("this baud rate cannot be had"),
};
/// Room for twice the longest frame.
const ROOM: usize = 512;

static RECEIVED: Ring<u8, ROOM> = Ring::new(0);
const CHANNEL: Channel = Channel::of_second(0);
/// Request of LPUART1's receiver (RM0440 13.3.2, table of requests).
const REQUEST: u8 = 34;
/// LPUART1_TX, PA2, and LPUART1_RX, PA3 (DS12288, alternate functions).
const FUNCTION: u8 = 12;

/// The link.
pub struct Link {
    reader: Reader<ROOM>,
}

impl Link {
    /// Starts the link.
    pub fn start() -> Self {
        Pin::new(GPIOA, 2).alternate(FUNCTION, Pupdr::FLOATING);
        // Idle is high, also without a cable.
        Pin::new(GPIOA, 3).alternate(FUNCTION, Pupdr::PULL_UP);
        // LPUART_BRR (38.7.5), whose 20 bits are more than the description of the part knows; RCC_CCIPR.LPUART1SEL is PCLK1 after reset (7.4.26).
        LPUART1.brr().write_value(Brr(DIVIDER));
        // LPUART_CR3 (38.7.4): the receiver asks for DMA, and goes on after an overrun: the frames have checksums.
        LPUART1.cr3().write(|w| {
            w.set_dmar(true);
            w.set_ovrdis(true);
        });
        CHANNEL.start(REQUEST, LPUART1.rdr().as_ptr().cast(), &RECEIVED, Way::In, Pl::MEDIUM);
        // LPUART_CR1 (38.7.1): with its buffers.
        LPUART1.cr1().write(|w| {
            w.set_fifoen(true);
            w.set_te(true);
            w.set_re(true);
        });
        LPUART1.cr1().modify(|w| w.set_ue(true));
        Link { reader: Reader::default() }
    }

    /// LPUART_ISR.TXFNF (38.7.7), which has the place of TXE.
    fn has_room(&self) -> bool {
        LPUART1.isr().read().txe()
    }
}

/// The place in the ring that is filled next.
fn filled() -> usize {
    position::<ROOM>(CHANNEL.remaining().into())
}

impl ErrorType for Link {
    type Error = Infallible;
}

impl ReadReady for Link {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.reader.waiting(filled()) > 0)
    }
}

impl Read for Link {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        let mut count = 0;
        for byte in bytes {
            let Some(place) = self.reader.take(filled()) else { break };
            *byte = RECEIVED.places()[place].read();
            count += 1;
        }
        Ok(count)
    }
}

impl WriteReady for Link {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.has_room())
    }
}

impl Write for Link {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let mut count = 0;
        for &byte in bytes.iter().take_while(|_| self.has_room()) {
            // LPUART_TDR (38.7.10).
            LPUART1.tdr().write(|w| w.set_dr(byte.into()));
            count += 1;
        }
        Ok(count)
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        // The transmitter sends what it has by itself: a hundred microseconds at most. LPUART_ISR.TC (38.7.7).
        while !LPUART1.isr().read().tc() {}
        Ok(())
    }
}
