//! The reference of the tests on the target: a power-up that the host plays when this package is
//! built.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(target_os = "none")]
pub mod stream;

/// The reference that the host has played.
#[cfg(target_os = "none")]
pub mod of_the_host {
    use crate::stream::Played;

    include!(concat!(env!("OUT_DIR"), "/of_the_host.rs"));
}
