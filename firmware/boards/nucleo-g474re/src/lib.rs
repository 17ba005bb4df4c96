//! What of the board needs no board: pure functions of numbers that its registers and rings hold, tested on the host. What another board would have
//! too is in `boards_common`.
#![no_std]
#![forbid(unsafe_code)]

pub mod alarm;
pub mod baud;
pub mod blocks;
pub mod config;
pub mod degrees;
pub mod options;
pub mod pages;
pub mod sampling;
pub mod slots;
pub mod stack;
pub mod trips;
