//! Interface between the processor and the chip around it.

use crate::interrupts::Interrupts;
use crate::memory::Memory;

/// Cycles of the processor's clock since power-on. Never decreases, not even at a reset.
pub type Cycle = u64;

/// Width of an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// 8 bits.
    Byte,
    /// 16 bits.
    Half,
    /// 32 bits.
    Word,
}

/// Access of the data bus to an address without memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// Address, aligned to the width.
    pub address: u32,
    /// Width of the access.
    pub width: Width,
    /// Cycle of the access.
    pub at: Cycle,
    /// Address of the instruction.
    pub pc: u32,
}

/// Executed breakpoint instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Breakpoint {
    /// Number in the instruction; 0xAB is semihosting.
    pub number: u8,
    /// R0: the operation in semihosting.
    pub r0: u32,
    /// R1: the argument in semihosting.
    pub r1: u32,
    /// Address of the instruction.
    pub pc: u32,
    /// Cycle of the execution.
    pub at: Cycle,
}

/// Reason for which an access fails.
#[derive(Debug)]
pub enum Fault {
    /// No answer at this address: the processor takes a bus fault.
    Bus,
    /// Error of the program, or a behaviour that the model lacks. Hardware would continue; the run
    /// stops with this finding.
    Stop(Box<dyn std::error::Error + Send + Sync>),
}

/// Access of the chip to memories and lines outside its own registers.
pub struct Ports<'a> {
    /// Flash and RAM.
    pub memory: &'a mut Memory,
    /// Lines to the interrupt controller, and to reset.
    pub interrupts: &'a mut Interrupts,
}

/// Chip around the processor: its peripherals, DMA and flash accelerator.
pub trait Chip {
    /// Loads from an address outside the readable memories.
    fn read(&mut self, access: Access, ports: Ports) -> Result<u32, Fault>;

    /// Stores to an address outside the writable memories; flash counts as not writable.
    fn write(&mut self, access: Access, value: u32, ports: Ports) -> Result<(), Fault>;

    /// Returns the cycle of the chip's next own event.
    ///
    /// [`advance`](Chip::advance) is called no later than with the first instruction that ends at
    /// or after it. Read again after every access and every `advance`.
    fn due(&self) -> Cycle;

    /// Executes all events up to `now`, in order.
    fn advance(&mut self, now: Cycle, ports: Ports) -> Result<(), Fault>;

    /// Returns the wait states, in cycles, of fetching the aligned 8 bytes at `address` from a
    /// [`Region`](crate::Region) with wait states. Called when the fetch enters a new group of 8
    /// bytes.
    fn fetch_wait(&mut self, address: u32, at: Cycle) -> u32;

    /// Returns the wait states, in cycles, of a data load from such a region.
    fn load_wait(&mut self, address: u32, at: Cycle) -> u32;

    /// Returns the wait states, in cycles, of an access to the chip's registers.
    fn access_wait(&mut self, _address: u32) -> u32 {
        0
    }

    /// Returns the maximum number of cycles that other bus masters can have delayed the processor
    /// since the last call. Used only with [`Timing::Longest`](crate::Timing::Longest).
    fn held_up(&mut self) -> u32 {
        0
    }

    /// Reports a load or fetch from a place that [`Memory::damage`] has marked. The chip may pend
    /// its NMI; the read continues.
    fn damaged(&mut self, address: u32, ports: Ports) -> Result<(), Fault>;

    /// Reports that the processor has locked up: a fault within the hard fault or NMI handler.
    fn lockup(&mut self, at: Cycle, ports: Ports) -> Result<(), Fault>;

    /// Executes a breakpoint instruction.
    ///
    /// `Some`: the program continues with this value in R0, as after a semihosting call. `None`: no
    /// debugger or host is attached, and the processor takes a hard fault.
    fn breakpoint(&mut self, _breakpoint: Breakpoint, _ports: Ports) -> Result<Option<u32>, Fault> {
        Ok(None)
    }

    /// Reports that a debugger halts or resumes the processor.
    fn halt(&mut self, _at: Cycle, _halted: bool, _ports: Ports) -> Result<(), Fault> {
        Ok(())
    }

    /// Resets the registers after a reset by the chip itself or by `SYSRESETREQ`. Memories keep
    /// their contents.
    fn reset(&mut self, at: Cycle, ports: Ports);
}
