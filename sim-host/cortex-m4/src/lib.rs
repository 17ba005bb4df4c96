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

mod chip;
mod interrupts;
mod memory;

pub use chip::{Access, Chip, Cycle, Fault, Ports, Width};
pub use interrupts::{Interrupts, LINES};
pub use memory::{Memory, Region};
