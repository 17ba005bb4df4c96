//! Loads the core-coupled RAM with the code that `ccmram.x` assigns to it. RM0440 2.4: this RAM has
//! no wait states, and no DMA channel of this image uses it.
#![expect(unsafe_code, reason = "code is copied to an address from the linker")]

use core::ptr::{addr_of, addr_of_mut};

unsafe extern "C" {
    static __siccmram: u32;
    static mut __sccmram: u32;
    static mut __eccmram: u32;
}

/// Copies the code. Must be called before any copied function.
pub fn load() {
    let (from, to, end) = (addr_of!(__siccmram), addr_of_mut!(__sccmram), addr_of_mut!(__eccmram));
    let words = (end as usize - to as usize) / size_of::<u32>();
    // SAFETY: as below. The first write to a RAM after a reset may be lost (ES0430 2.2.7): this
    // word is written again.
    unsafe { to.write_volatile(from.read_volatile()) };
    for word in 0..words {
        // SAFETY: the linker script reserves both ranges with equal length and an alignment of
        // eight; no code runs from there yet.
        unsafe { to.add(word).write_volatile(from.add(word).read_volatile()) };
    }
    // The copied words are code: complete the writes before any instruction fetch.
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
