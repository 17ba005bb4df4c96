//! Field update of a board with a first stage: pure functions and state machines over `embedded-storage`, the same on the board and on the host.
//!
//! ```text
//! slot (bank 1)                       store (bank 2)                     state (bank 2)
//! manifest | image that runs          manifest | image that is received  of embassy-boot: swap, trial, progress
//!     ^                                   ^                                  ^
//!     +-- first stage: swaps page by page-+----------------------------------+
//! ```
//!
//! [`manifest`] says what an image is; [`check`] holds stored bytes against it; [`receive`] is the running image's side; [`first_stage`] decides
//! after each reset what is started. The swap, its progress and the return to the former image are those of the crate `embassy-boot`.
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
