//! USART1 of the STM32F405 (RM0090 30.6), which QEMU connects to its first serial port.
//!
//! QEMU sends a byte at once. It delivers received bytes one by one, and only while the processor
//! sleeps or runs, never while it waits for a record of the host. The receiver therefore sleeps
//! until all bytes that the host has sent are received, which makes every dialogue reproducible.
#![expect(unsafe_code, reason = "access to registers")]

use core::convert::Infallible;
use core::ptr;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::Peripherals;
use cortex_m::asm::wfi;
use cortex_m::interrupt::{self, InterruptNumber};
use cortex_m::peripheral::{NVIC, SCB};
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

/// Address of USART1.
const BASE: usize = 0x4001_1000;
/// Status register (30.6.1).
const SR: usize = BASE;
/// Flag of the status register: the receive register is not empty.
const RXNE: u32 = 1 << 5;
/// Flag of the status register: the transmit register is empty.
const TXE: u32 = 1 << 7;
/// Data register (30.6.2).
const DR: usize = BASE + 0x04;
/// Control register 1 (30.6.4).
const CR1: usize = BASE + 0x0c;
/// Value of control register 1: USART enabled, receive interrupt, transmitter, receiver.
const CR1_ENABLED: u32 = 1 << 13 | 1 << 5 | 1 << 3 | 1 << 2;

/// Longest sleep, ticks of the system timer: 0.1 s.
const MAX_SLEEP_TICKS: u32 = 0x00ff_ffff;
/// Number of sleeps after which missing bytes of the host count as lost.
const MAX_SLEEPS: u32 = 20;

/// Number of bytes that the host has sent since the start of the board.
static SENT: AtomicU32 = AtomicU32::new(0);

/// Sets the number of bytes that the host has sent so far. The link receives them before it does
/// anything else.
pub fn receive(sent: u32) {
    SENT.store(sent, Ordering::Relaxed);
}

/// Interrupt of USART1 (RM0090 12.2, table of vectors). It wakes the processor and is never served.
#[derive(Clone, Copy)]
struct Interrupt;

// SAFETY: the number of USART1, which is within the vector table of cortex-m-rt.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        37
    }
}

fn read(register: usize) -> u32 {
    // SAFETY: an aligned register of the processor. Reading the data register removes a byte, which
    // is intended.
    unsafe { ptr::read_volatile(ptr::with_exposed_provenance::<u32>(register)) }
}

fn write(register: usize, value: u32) {
    // SAFETY: an aligned register of the processor, which only this module writes.
    unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut::<u32>(register), value) }
}

/// Serial port of the link.
pub struct Usart {
    taken: u32,
}

impl Usart {
    /// Starts the serial port, and the system timer that wakes the receiver.
    pub fn start(core: &mut Peripherals) -> Self {
        interrupt::disable();
        core.SYST.set_reload(MAX_SLEEP_TICKS);
        core.SYST.enable_interrupt();
        core.SYST.enable_counter();
        // SAFETY: interrupts stay disabled, so that this one only wakes the processor and no
        // handler runs.
        unsafe { NVIC::unmask(Interrupt) };
        write(CR1, CR1_ENABLED);
        Usart { taken: 0 }
    }

    /// Sleeps until a byte is received. Returns `false` if none comes.
    fn wait(&self) -> bool {
        for _ in 0..MAX_SLEEPS {
            if read(SR) & RXNE != 0 {
                return true;
            }
            wfi();
            NVIC::unpend(Interrupt);
            SCB::clear_pendst();
        }
        false
    }
}

impl ErrorType for Usart {
    type Error = Infallible;
}

impl ReadReady for Usart {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.taken != SENT.load(Ordering::Relaxed) && self.wait())
    }
}

impl Read for Usart {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        let mut count = 0;
        while count < bytes.len() && self.read_ready()? {
            bytes[count] = read(DR) as u8;
            self.taken = self.taken.wrapping_add(1);
            count += 1;
        }
        Ok(count)
    }
}

impl WriteReady for Usart {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(read(SR) & TXE != 0)
    }
}

impl Write for Usart {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let mut count = 0;
        for &byte in bytes.iter().take_while(|_| read(SR) & TXE != 0) {
            write(DR, byte.into());
            count += 1;
        }
        Ok(count)
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        // The transmitter sends its data without help.
        Ok(())
    }
}
