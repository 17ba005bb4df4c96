//! Shared parts of the images for the emulated Cortex-M4F: test bench of the controller, counter of
//! instructions, stack measurement, and the pipes to the host.
//!
//! On the host only the test bench is available.
#![no_std]

pub mod bench;

#[cfg(target_os = "none")]
pub mod counter;
#[cfg(target_os = "none")]
mod hard_fault;
#[cfg(target_os = "none")]
pub mod pages;
#[cfg(target_os = "none")]
pub mod pipes;
#[cfg(target_os = "none")]
pub mod stack;
