//! Setup of the guard below the stack ([`GUARD`]) in the memory protection unit. ARM DDI 0403 B3.5.
#![expect(unsafe_code, reason = "access to registers of the processor")]

use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::{MPU, SCB};
use nucleo_g474re::stack::GUARD;

/// Starts the guard. The stack pointer must be above it.
pub fn start(unit: &MPU) {
    /// Value of MPU_CTRL: on (ENABLE), off in hard fault handlers, and the default memory map
    /// elsewhere (PRIVDEFENA).
    const CONTROL: u32 = 1 << 2 | 1;
    // SAFETY: region 0 contains no static memory (ensured by the linker script) and no used part of
    // the stack.
    unsafe {
        unit.rnr.write(0);
        unit.rbar.write(GUARD.start());
        unit.rasr.write(GUARD.attributes());
        unit.ctrl.write(CONTROL);
    }
    dsb();
    isb();
}

/// Returns `true` if the current fault is a stack overflow: CFSR (B3.2.15), MMFAR (B3.2.18).
pub fn has_overflowed() -> bool {
    // SAFETY: reads two registers without side effects.
    let (status, address) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).mmfar.read()) };
    GUARD.has_overflowed(status, address)
}
