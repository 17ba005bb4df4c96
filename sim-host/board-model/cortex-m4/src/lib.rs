//! Cortex-M4 with FPU in software: runs an unmodified ELF and counts instructions and cycles.
//!
//! ```text
//! ELF --> Memory <--> processor <--> Chip (registers of the microcontroller, in another crate)
//!                        ^              |
//!                        +- Interrupts -+
//! ```
//!
//! The crate contains the processor and its private peripherals (NVIC, SCB, SysTick, MPU, and the
//! cycle counter of the DWT). An implementation of [`Chip`] contains the rest of the
//! microcontroller: its registers, DMA and flash accelerator.
//!
//! A program of three instructions, with a chip that has only memory:
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
//! let mut machine = Machine::from_memory(memory, Bare, 0, 4);
//! machine.run_until(2)?;
//! assert_eq!(machine.register(0), 36);
//! assert_eq!((machine.instructions(), machine.cycle()), (2, 2));
//! # Ok::<(), sonoglide_cortex_m4::Stop>(())
//! ```
//!
//! [`Machine::new`] loads an ELF file, with the names of its functions for findings ([`Stop`]) and
//! profiles ([`Profile`]).
//!
//! # Modelled
//!
//! * All instructions of ARMv7E-M with FPv4-SP, with all rounding modes, flush-to-zero and
//!   cumulative flags. The test `qemu` compares random instructions from random states with QEMU,
//!   word by word; no difference is known. Encodings that the manual calls unpredictable do
//!   something simple or are undefined.
//! * Exceptions with priorities, tail-chaining, lazy stacking of floating-point registers,
//!   escalation and lockup. An access to a processor register that is not modelled stops the run.
//! * Cycles without contention on the buses, either the usual number or the maximum of the manual:
//!   [`cycles`], [`Timing`].
//! * A debugger's halt, steps, and runs to any number of breakpoints: [`Machine::run_to`],
//!   [`Machine::step_over`], [`Machine::halt_until`].
//!
//! # Not modelled
//!
//! * Late arrival: an exception that comes during the entry of another waits for its end. `LDM`,
//!   `STM` and divisions are never abandoned.
//! * Imprecise faults: faults of stores are precise. In hardware the write buffer may delay them by
//!   some instructions.
//! * MPU checks of fetches; the MPU checks only data.
//! * Registers of the debug monitor, the breakpoint and trace units, watchpoints, and counters of
//!   the DWT other than CYCCNT.
//! * The end of a lockup by an NMI; only a reset ends it.
//! * Cycles to enter or leave sleep. The reference clock of SysTick is an eighth of the
//!   processor's.
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
pub use profile::{Handled, InFunction, Profile, Spent};
pub use timing::Timing;
pub use watch::{Fetches, Passage};
