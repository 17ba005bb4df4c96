//! What images on the emulated Cortex-M4F share: what the controller is tried on, counting instructions, measuring the stack, and the pipes to
//! the host.
//!
//! On the host there is the first of it only.
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
