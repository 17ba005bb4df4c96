//! USART1 of the STM32F405 (RM0090 30.6), which QEMU connects with its first serial port.
//!
//! QEMU sends a byte at once. It hands over the bytes that come one by one, and only while the processor sleeps or runs, never while it waits
//! for the host's record: so the receiver sleeps until what the host has sent is there. A dialogue is then the same every time.
#![expect(unsafe_code, reason = "registers")]

use core::convert::Infallible;
use core::ptr;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::Peripherals;
use cortex_m::asm::wfi;
use cortex_m::interrupt::{self, InterruptNumber};
use cortex_m::peripheral::{NVIC, SCB};
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

const BASE: usize = 0x4001_1000;
/// Status (30.6.1), with "not empty" and "empty"; data (30.6.2); control (30.6.4), with enable, interrupt of the receiver, transmitter, receiver.
const SR: usize = BASE;
const RXNE: u32 = 1 << 5;
const TXE: u32 = 1 << 7;
const DR: usize = BASE + 0x04;
const CR1: usize = BASE + 0x0c;
const STARTED: u32 = 1 << 13 | 1 << 5 | 1 << 3 | 1 << 2;

/// Longest sleep, ticks of the system timer: 0.1 s.
const SLEEP: u32 = 0x00ff_ffff;
/// So many of them, and what the host says it has sent is taken as lost.
const MOST_SLEEPS: u32 = 20;

/// Bytes that the host has sent since the board was started.
static SENT: AtomicU32 = AtomicU32::new(0);

/// Sets how many bytes the host has sent so far: they are received before anything else is done.
pub fn receive(sent: u32) {
    SENT.store(sent, Ordering::Relaxed);
}

/// Its interrupt (RM0090 12.2, table of vectors): it wakes, and is never served.
#[derive(Clone, Copy)]
struct Interrupt;

// SAFETY: the number of USART1, below the vectors that cortex-m-rt has.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        37
    }
}

fn read(register: usize) -> u32 {
    // SAFETY: a register of the part, aligned; reading the data register takes a byte out, which is what it is read for.
    unsafe { ptr::read_volatile(ptr::with_exposed_provenance::<u32>(register)) }
}

fn write(register: usize, value: u32) {
    // SAFETY: a register of the part, aligned, which only this module writes to.
    unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut::<u32>(register), value) }
}

/// The serial port of the link.
pub struct Usart {
    taken: u32,
}

impl Usart {
    /// Starts it, and the system timer as its alarm clock.
    pub fn start(core: &mut Peripherals) -> Self {
        interrupt::disable();
        core.SYST.set_reload(SLEEP);
        core.SYST.enable_interrupt();
        core.SYST.enable_counter();
        // SAFETY: interrupts are off for good, so that it wakes and nothing is called.
        unsafe { NVIC::unmask(Interrupt) };
        write(CR1, STARTED);
        Usart { taken: 0 }
    }

    /// Sleeps until a byte is there. Whether one is.
    fn wait(&self) -> bool {
        for _ in 0..MOST_SLEEPS {
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
        // The transmitter sends what it has by itself.
        Ok(())
    }
}
