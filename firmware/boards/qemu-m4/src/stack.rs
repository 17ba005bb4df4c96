//! Measurement of the stack depth: the free memory below the stack is painted, and later searched
//! for the first changed word.
//!
//! ```text
//! _stack_start |####### in use #######| paint ................ paint | _stack_end: the static variables
//!                                      ^ stack pointer
//! later        |#######################|==== used since ====| paint |
//! ```
//!
//! A word is not detected if it was overwritten with the paint value. Stack memory that a function
//! has reserved but not written is not detected either.
#![expect(unsafe_code, reason = "the memory of the stack is accessed directly")]

use core::ptr;

use cortex_m::register::msp;

/// Value of a painted word.
const PAINT: u32 = 0x5aa5_c33c;
/// Unpainted margin for the painting function itself, bytes.
const MARGIN: usize = 64;
const WORD: usize = size_of::<u32>();

unsafe extern "C" {
    // Top and end of the stack, from the linker script of cortex-m-rt. Only their addresses have a
    // meaning.
    static _stack_start: u32;
    static _stack_end: u32;
}

fn top() -> usize {
    (&raw const _stack_start).addr()
}

fn end() -> usize {
    (&raw const _stack_end).addr()
}

/// Paints the free memory below the stack.
#[inline(never)]
pub fn paint() {
    for address in (end()..msp::read() as usize - MARGIN).step_by(WORD) {
        // SAFETY: RAM between the static variables and the stack, which no variable owns. No
        // function is called meanwhile, and no interrupt that could need more than the margin is
        // enabled.
        unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut::<u32>(address), PAINT) };
    }
}

/// Returns the largest depth of the stack since it was painted, bytes from its top. It includes the
/// depth at that time.
#[inline(never)]
pub fn deepest_bytes() -> u32 {
    let touched = (end()..top()).step_by(WORD).find(|&address| {
        // SAFETY: aligned words of RAM. Values that belong to calling functions are only read as
        // bits and compared.
        unsafe { ptr::read_volatile(ptr::with_exposed_provenance::<u32>(address)) != PAINT }
    });
    (top() - touched.unwrap_or(top())) as u32
}
