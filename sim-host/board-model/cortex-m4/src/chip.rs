//! The part around the processor, as the processor sees it.

use crate::interrupts::Interrupts;
use crate::memory::Memory;

/// Cycles of the processor's clock since power-on. Never goes back, not even at a reset.
pub type Cycle = u64;

/// How wide an access is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// 8 bits.
    Byte,
    /// 16 bits.
    Half,
    /// 32 bits.
    Word,
}

/// One access of the data bus to something that is no memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// The address, aligned to the width.
    pub address: u32,
    /// How wide the access is.
    pub width: Width,
    /// When it happens.
    pub at: Cycle,
    /// The instruction that does it.
    pub pc: u32,
}

/// A breakpoint instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Breakpoint {
    /// Its number; 0xAB asks for semihosting.
    pub number: u8,
    /// R0: the operation, in semihosting.
    pub r0: u32,
    /// R1: its argument, in semihosting.
    pub r1: u32,
    /// Address of the instruction.
    pub pc: u32,
    /// When it executes.
    pub at: Cycle,
}

/// Why an access is not answered.
#[derive(Debug)]
pub enum Fault {
    /// Nothing answers: the processor takes a bus fault.
    Bus,
    /// The part would go on, but what the program does is wrong or unknown to the model: the run stops with this finding.
    Stop(Box<dyn std::error::Error + Send + Sync>),
}

/// What a part can reach besides its own registers.
pub struct Ports<'a> {
    /// Flash and RAM.
    pub memory: &'a mut Memory,
    /// The lines into the interrupt controller, and to reset.
    pub interrupts: &'a mut Interrupts,
}

/// The part around the processor: its peripherals, its DMA, its flash accelerator.
pub trait Chip {
    /// A load from an address outside the readable memories.
    fn read(&mut self, access: Access, ports: Ports) -> Result<u32, Fault>;

    /// A store to an address outside the writable memories; flash is one.
    fn write(&mut self, access: Access, value: u32, ports: Ports) -> Result<(), Fault>;

    /// When something next happens by itself: [`advance`](Chip::advance) is called no later than with the first instruction that ends
    /// at or after it. Asked again after every access and every `advance`.
    fn due(&self) -> Cycle;

    /// Lets happen, in order, what is due until `now`.
    fn advance(&mut self, now: Cycle, ports: Ports) -> Result<(), Fault>;

    /// Wait states, in cycles, of fetching the aligned 8 bytes at `address` from a [`Region`](crate::Region) with wait states. Called when the
    /// fetch enters other 8 bytes than before.
    fn fetch_wait(&mut self, address: u32, at: Cycle) -> u32;

    /// Wait states, in cycles, of a load of data from such a region.
    fn load_wait(&mut self, address: u32, at: Cycle) -> u32;

    /// Wait states, in cycles, of an access to the part's registers.
    fn access_wait(&mut self, _address: u32) -> u32 {
        0
    }

    /// Cycles for which other masters of the buses can have held up the processor, at most, since this was asked last. Counted with
    /// [`Timing::Longest`](crate::Timing::Longest) only.
    fn held_up(&mut self) -> u32 {
        0
    }

    /// A load or a fetch hit a place that [`Memory::damage`] has named. The part may pend its NMI; the read goes on.
    fn damaged(&mut self, address: u32, ports: Ports) -> Result<(), Fault>;

    /// The processor has locked up: a fault within the hard fault or NMI handler.
    fn lockup(&mut self, at: Cycle, ports: Ports) -> Result<(), Fault>;

    /// A breakpoint instruction executes. With a value the program goes on and finds it in R0, as after a semihosting call; without one there is
    /// no debugger and no host, and the processor takes a hard fault.
    fn breakpoint(&mut self, _breakpoint: Breakpoint, _ports: Ports) -> Result<Option<u32>, Fault> {
        Ok(None)
    }

    /// A debugger halts the processor, or lets it go on.
    fn halt(&mut self, _at: Cycle, _halted: bool, _ports: Ports) -> Result<(), Fault> {
        Ok(())
    }

    /// The reset line was pulled, by the part itself or by `SYSRESETREQ`: registers go to their reset values. Memories keep theirs.
    fn reset(&mut self, at: Cycle, ports: Ports);
}
