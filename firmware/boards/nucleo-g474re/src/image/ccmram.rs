//! Loads the core-coupled RAM with the code that `ccmram.x` has put there. RM0440 2.4: it has no wait states, and no DMA channel of this image uses it.
#![expect(unsafe_code, reason = "code is copied to where the linker says")]

use core::ptr::{addr_of, addr_of_mut};

unsafe extern "C" {
    static __siccmram: u32;
    static mut __sccmram: u32;
    static mut __eccmram: u32;
}

/// Copies the code. Called first: no copied function may be called before.
pub fn load() {
    let (from, to, end) = (addr_of!(__siccmram), addr_of_mut!(__sccmram), addr_of_mut!(__eccmram));
    let words = (end as usize - to as usize) / size_of::<u32>();
    for word in 0..words {
        // SAFETY: the linker script reserves both ranges, as long as each other and aligned to eight; nothing runs from there yet.
        unsafe { to.add(word).write_volatile(from.add(word).read_volatile()) };
    }
    // What was written is to be executed.
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
