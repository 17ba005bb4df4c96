//! How deep the stack has been: what lies below it is painted, and looked at again later, from its end up.
//!
//! ```text
//! _stack_start |####### in use #######| paint ................ paint | _stack_end: the static variables
//!                                      ^ stack pointer
//! later        |#######################|==== used since ====| paint |
//! ```
//!
//! A word that was written to and is as painted is not seen, nor is room that a function has taken and not written to: the mark is
//! of what was touched.
#![expect(unsafe_code, reason = "the stack is looked at from outside of it")]

use core::ptr;

use cortex_m::register::msp;

/// What is painted.
const PAINT: u32 = 0x5aa5_c33c;
/// What is left for the painter itself, bytes.
const MARGIN: usize = 64;
const WORD: usize = size_of::<u32>();

unsafe extern "C" {
    /// The top of the stack, and its end, by the linker's script of cortex-m-rt. Their addresses are what counts.
    static _stack_start: u32;
    static _stack_end: u32;
}

fn top() -> usize {
    (&raw const _stack_start).addr()
}

fn end() -> usize {
    (&raw const _stack_end).addr()
}

/// Paints what is below the stack.
#[inline(never)]
pub fn paint() {
    for address in (end()..msp::read() as usize - MARGIN).step_by(WORD) {
        // SAFETY: RAM between the static variables and the stack, which no variable owns: no function is called while it is painted, and no
        // interrupt is enabled that would be lower than the margin.
        unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut::<u32>(address), PAINT) };
    }
}

/// The deepest that the stack was since it was painted, bytes from its top; at least as deep as it was then.
#[inline(never)]
pub fn deepest_bytes() -> u32 {
    let touched = (end()..top()).step_by(WORD).find(|&address| {
        // SAFETY: aligned words of RAM. What a function above this one has there is read as bits, and not used.
        unsafe { ptr::read_volatile(ptr::with_exposed_provenance::<u32>(address)) != PAINT }
    });
    (top() - touched.unwrap_or(top())) as u32
}
