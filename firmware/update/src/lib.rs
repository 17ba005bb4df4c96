//! Field update of a board with a first stage: pure functions and state machines over
//! `embedded-storage`, which run on the board and on the host.
//!
//! ```text
//! slot (bank 1)                       store (bank 2)                     state (bank 2)
//! manifest | running image            manifest | received image          of embassy-boot: swap, trial, progress
//!     ^                                   ^                                  ^
//!     +-- first stage: swaps page by page-+----------------------------------+
//! ```
//!
//! [`manifest`] describes an image; [`check`] compares stored bytes with it; [`receive`] runs in
//! the image; [`first_stage`] decides after each reset which image is started. The crate
//! `embassy-boot` performs the swap, stores its progress, and swaps back to the former image.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod check;
#[cfg(feature = "flash")]
pub mod first_stage;
pub mod identity;
pub mod key;
pub mod manifest;
#[cfg(feature = "flash")]
pub mod receive;

#[cfg(all(test, feature = "flash"))]
mod tests;
