//! A Cortex-M4 with FPU in software: it runs an unmodified ELF and counts instructions and cycles.
//!
//! ```text
//! ELF --> Memory <--> processor <--> Chip (registers of the part, in another crate)
//!                        ^              |
//!                        +- Interrupts -+
//! ```
//!
//! The crate knows the processor and its private peripherals (NVIC, SCB, SysTick, DWT). What else a part has stands behind
//! [`Chip`]: its registers, its DMA, its flash accelerator.
#![forbid(unsafe_code)]

mod bus;
mod chip;
mod cpu;
pub mod cycles;
mod decode;
mod elf;
mod exceptions;
mod execute;
mod float;
mod interrupts;
mod machine;
mod memory;
mod op;
mod profile;

pub use chip::{Access, Breakpoint, Chip, Cycle, Fault, Ports, Width};
pub use elf::{Function, ImageError, Symbols};
pub use exceptions::UnknownRegister;
pub use interrupts::{Interrupts, LINES};
pub use machine::{Machine, Stop};
pub use profile::{Handled, Profile, Spent};
pub use memory::{Memory, Region};
