//! Link to the host: LPUART1 on PA2 and PA3, which the Nucleo's ST-LINK provides as a serial port
//! (UM2505). 921 600 baud, 8N1. RM0440 38.
//!
//! DMA writes received bytes to a ring, so that none is lost while the background task is busy for
//! up to 5 ms. Bytes are sent through the transmitter's buffer of eight, one at each poll. Only a
//! flush waits, before a reset.

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
use super::dma::{Channel, Direction, Ring};
use super::pins::Pin;

/// Speed of the link, bit/s.
pub const BAUD: u32 = 921_600;
/// Divider of the clock.
const DIVIDER: u32 = match divider(SYSTEM_HZ, BAUD) {
    Some(divider) => divider,
    None => panic!("the clock cannot produce this baud rate"),
};
/// Size of the receive ring, bytes: twice the longest frame.
const ROOM: usize = 512;

static RECEIVED: Ring<u8, ROOM> = Ring::new(0);
const CHANNEL: Channel = Channel::of_dma2(0);
/// DMA request number of LPUART1's receiver (RM0440 13.3.2, table of requests).
const REQUEST: u8 = 34;
/// Alternate function of LPUART1_TX, PA2, and LPUART1_RX, PA3 (DS12288, alternate functions).
const FUNCTION: u8 = 12;

/// Link to the host.
pub struct Link {
    reader: Reader<ROOM>,
}

impl Link {
    /// Starts the link.
    pub fn start() -> Self {
        Pin::new(GPIOA, 2).alternate(FUNCTION, Pupdr::FLOATING);
        // The idle level is high, also without a cable.
        Pin::new(GPIOA, 3).alternate(FUNCTION, Pupdr::PULL_UP);
        // LPUART_BRR (38.7.5): raw, because `stm32-metapac` describes fewer than its 20 bits.
        // RCC_CCIPR.LPUART1SEL is PCLK1 after reset (7.4.26).
        LPUART1.brr().write_value(Brr(DIVIDER));
        // LPUART_CR3 (38.7.4): the receiver uses DMA and continues after an overrun. The checksums
        // of the frames detect the loss.
        LPUART1.cr3().write(|w| {
            w.set_dmar(true);
            w.set_ovrdis(true);
        });
        CHANNEL.start(REQUEST, LPUART1.rdr().as_ptr().cast(), &RECEIVED, Direction::In, Pl::MEDIUM);
        // LPUART_CR1 (38.7.1): the FIFOs are enabled.
        LPUART1.cr1().write(|w| {
            w.set_fifoen(true);
            w.set_te(true);
            w.set_re(true);
        });
        LPUART1.cr1().modify(|w| w.set_ue(true));
        Link { reader: Reader::default() }
    }

    /// Returns `true` if the transmitter has room: LPUART_ISR.TXFNF (38.7.7), which is at the
    /// position of TXE.
    fn has_room(&self) -> bool {
        LPUART1.isr().read().txe()
    }
}

/// Returns the place in the ring that DMA fills next.
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
        // Waits until the transmitter is empty, which takes at most a hundred microseconds.
        // LPUART_ISR.TC (38.7.7).
        while !LPUART1.isr().read().tc() {}
        Ok(())
    }
}
