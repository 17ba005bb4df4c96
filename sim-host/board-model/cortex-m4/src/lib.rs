//! A Cortex-M4 with FPU in software: it runs an unmodified ELF and counts instructions and cycles.
//!
//! ```text
//! ELF --> Memory <--> processor <--> Chip (registers of the part, in another crate)
//!                        ^              |
//!                        +- Interrupts -+
//! ```
//!
//! The crate knows the processor and its private peripherals (NVIC, SCB, SysTick, MPU, DWT's cycle counter). What else a part has stands behind
//! [`Chip`]: its registers, its DMA, its flash accelerator.
//!
//! A program of three instructions, with a part that has memory only:
//!
//! ```
//! use sonoglide_cortex_m4::{Access, Chip, Cycle, Fault, Machine, Memory, Ports, Region};
//!
//! struct Bare;
//!
//! impl Chip for Bare {
//!     fn read(&mut self, _: Access, _: Ports) -> Result<u32, Fault> { Err(Fault::Bus) }
//!     fn write(&mut self, _: Access, _: u32, _: Ports) -> Result<(), Fault> { Err(Fault::Bus) }
//!     fn due(&self) -> Cycle { Cycle::MAX }
//!     fn advance(&mut self, _: Cycle, _: Ports) -> Result<(), Fault> { Ok(()) }
//!     fn fetch_wait(&mut self, _: u32, _: Cycle) -> u32 { 0 }
//!     fn load_wait(&mut self, _: u32, _: Cycle) -> u32 { 0 }
//!     fn damaged(&mut self, _: u32, _: Ports) -> Result<(), Fault> { Ok(()) }
//!     fn lockup(&mut self, _: Cycle, _: Ports) -> Result<(), Fault> { Err(Fault::Stop("locked up".into())) }
//!     fn reset(&mut self, _: Cycle, _: Ports) {}
//! }
//!
//! // Stack pointer 0x100, entry 0x8; MOVS R0, #6; MUL R0, R0, R0; B to itself.
//! let halves: [u16; 7] = [0x0100, 0, 0x0009, 0, 0x2006, 0x4340, 0xE7FE];
//! let mut bytes: Vec<u8> = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
//! bytes.resize(256, 0);
//! let mut memory = Memory::default();
//! memory.add(Region { base: 0, bytes, writable: true, waits: false });
//!
//! let mut machine = Machine::of_memory(memory, Bare, 0, 4);
//! machine.run_until(2)?;
//! assert_eq!(machine.register(0), 36);
//! assert_eq!((machine.instructions(), machine.cycle()), (2, 2));
//! # Ok::<(), sonoglide_cortex_m4::Stop>(())
//! ```
//!
//! An ELF file is loaded by [`Machine::new`], which also takes over the names of its functions for findings ([`Stop`]) and profiles ([`Profile`]).
//!
//! # What is modelled
//!
//! * All instructions of ARMv7E-M with FPv4-SP, with all rounding modes, flush-to-zero and cumulative flags. The test `qemu` compares random
//!   instructions from random states with QEMU, word by word; no difference is known. Where the manual calls an encoding unpredictable, the model
//!   does something plain, or takes it as undefined.
//! * Exceptions with priorities, tail-chaining, lazy stacking of floating-point registers, escalation and lockup. An access to a register of the
//!   processor that is not modelled stops the run.
//! * Cycles without contention on the buses, as they usually are or as many as the manual allows: [`cycles`], [`Timing`].
//! * A debugger's halt, steps, and runs to breakpoints, as many as it likes: [`Machine::run_to`], [`Machine::step_over`], [`Machine::stand_until`].
//!
//! # What is not
//!
//! * Late arrival: an exception that comes during the entry of another waits until that has ended. `LDM`, `STM` and divisions are never abandoned.
//! * Faults of stores are precise; in the part they may come some instructions later, as the write buffer lets them.
//! * The MPU checks data, not fetches. The registers of the debug monitor, the breakpoint and the trace units and DWT's counters but CYCCNT do not
//!   exist, nor do watchpoints.
//! * A lockup ends with a reset only, not with an NMI.
//! * Sleep takes no cycles to enter or leave. The reference clock of SysTick is an eighth of the processor's.
#![forbid(unsafe_code)]

mod breakpoints;
mod bus;
mod chip;
mod cpu;
pub mod cycles;
mod decode;
mod elf;
mod exceptions;
mod execute;
mod fetch;
mod float;
mod halt;
mod inspect;
mod interrupts;
mod machine;
mod memory;
mod op;
mod profile;
pub mod timing;
mod watch;

pub use breakpoints::{BreakpointInstruction, Ended};
pub use chip::{Access, Breakpoint, Chip, Cycle, Fault, Ports, Width};
pub use elf::{Function, ImageError, Symbols};
pub use exceptions::UnknownRegister;
pub use interrupts::{Interrupts, LINES};
pub use machine::{Machine, Stop};
pub use memory::{Memory, Region};
pub use profile::{Handled, Profile, Spent};
pub use timing::Timing;
pub use watch::{Fetches, Passage};
