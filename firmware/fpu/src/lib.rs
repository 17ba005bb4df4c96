//! The square root in single precision, by the processor's floating-point unit.
//!
//! `core` has no stable square root, and `libm` computes it bit by bit. IEEE 754 requires it to be
//! correctly rounded, so that `VSQRT.F32` returns the same bits for every number.
//!
//! A crate of its own, because the controller forbids `unsafe`, which one instruction needs.

#![no_std]

/// Returns the square root, correctly rounded; not a number for a negative value.
#[cfg(not(all(target_os = "none", target_arch = "arm", target_abi = "eabihf")))]
pub fn sqrtf(x: f32) -> f32 {
    libm::sqrtf(x)
}

/// Returns the square root, correctly rounded; not a number for a negative value.
#[cfg(all(target_os = "none", target_arch = "arm", target_abi = "eabihf"))]
// SAFETY: argument and result are in `s0` (AAPCS, the variant with floating-point registers), and
// no register changes that a function must preserve.
#[unsafe(naked)]
pub extern "C" fn sqrtf(x: f32) -> f32 {
    // The assembler of a naked function does not know the features of the target.
    core::arch::naked_asm!(".fpu fpv4-sp-d16", "vsqrt.f32 s0, s0", "bx lr")
}
