//! Hardware-independent part of the board: pure functions of the values in its registers and rings,
//! tested on the host. Parts that other boards would need too are in `boards_common`.
#![no_std]
#![forbid(unsafe_code)]

pub mod alarm;
pub mod baud;
pub mod blocks;
pub mod config;
pub mod degrees;
pub mod errata;
pub mod options;
pub mod pages;
pub mod sampling;
pub mod slots;
pub mod stack;
pub mod trips;
