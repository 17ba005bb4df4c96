//! The registers of an STM32G474 in software, and a lint of how a program uses them.
//!
//! It is the [`Chip`](cortex_m4::Chip) around the processor of the crate `cortex-m4`. What hangs on its pins stands behind a trait of this crate.
#![forbid(unsafe_code)]

mod adc;
mod adc_control;
mod art;
mod comp;
mod dac;
mod defect;
mod dma;
mod factory;
mod finding;
mod flash;
mod gpio;
mod iwdg;
pub mod map;
mod part;
mod pwr;
mod rcc;
mod reset;
mod syscfg;
mod tim1;
mod time;
mod timer;
mod uart;
mod wires;

pub use defect::{Defect, Ram};
pub use finding::{Finding, Lint, NotModelled, Rule, Verdict};
pub use part::{Config, Stm32g474};
pub use wires::{Bare, Drive, Level, Pin, Received, Wires};
