//! What the tests on the target are held against: a power-up that the host has played when this package was built.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(target_os = "none")]
pub mod stream;

/// What the host has played.
#[cfg(target_os = "none")]
pub mod of_the_host {
    use crate::stream::Played;

    include!(concat!(env!("OUT_DIR"), "/of_the_host.rs"));
}
