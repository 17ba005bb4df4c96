//! First accesses to the RAMs after a reset, before any variable is initialised: ES0430 2.2.7.
//!
//! A reset at an unlucky instant can cause the first write to each part of the RAM to be lost. A
//! read takes its place. The first 32 KiB may have a parity check, which a read of unwritten RAM
//! would fail, so they are written; the word is initialised again afterwards.
#![expect(unsafe_code, reason = "runs before the variables are initialised, in assembly without a stack")]

use core::arch::naked_asm;

/// Runs as the first function after a reset. It must not use the stack.
#[unsafe(naked)]
// SAFETY: `cortex-m-rt` calls this symbol before it initialises the variables.
#[unsafe(no_mangle)]
unsafe extern "C" fn __pre_init() {
    naked_asm!(
        "movw r0, #:lower16:__sbss",
        "movt r0, #:upper16:__sbss",
        "movs r1, #0",
        "str r1, [r0]",
        "mov.w r0, #0x20000000",
        "add.w r0, r0, #0x8000",
        "ldr r1, [r0]",
        "add.w r0, r0, #0x8000",
        "ldr r1, [r0]",
        "add.w r0, r0, #0x4000",
        "ldr r1, [r0]",
        "dsb",
        "bx lr",
    )
}
