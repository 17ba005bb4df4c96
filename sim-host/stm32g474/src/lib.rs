//! The registers of an STM32G474 in software, and a lint of how a program uses them.
//!
//! It is the [`Chip`](cortex_m4::Chip) around the processor of the crate `cortex-m4`. What hangs on its pins stands behind a trait of this crate.
#![forbid(unsafe_code)]
