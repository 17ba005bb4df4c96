//! Sets up the guard below the stack ([`GUARD`]) in the memory protection unit. ARM DDI 0403 B3.5.
#![expect(unsafe_code, reason = "registers of the processor")]

use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::{MPU, SCB};
use nucleo_g474re::stack::GUARD;

/// Starts the guard. The stack must be above it.
pub fn start(unit: &MPU) {
    /// MPU_CTRL: on, off in the handlers of hard faults, and everything else as without it (ENABLE, PRIVDEFENA).
    const CONTROL: u32 = 1 << 2 | 1;
    // SAFETY: region 0 covers no static memory (the linker script sees to it) and nothing of the stack that is in use.
    unsafe {
        unit.rnr.write(0);
        unit.rbar.write(GUARD.start());
        unit.rasr.write(GUARD.attributes());
        unit.ctrl.write(CONTROL);
    }
    dsb();
    isb();
}

/// Whether the fault that is being handled is a stack overflow: CFSR (B3.2.15), MMFAR (B3.2.18).
pub fn has_overflowed() -> bool {
    // SAFETY: two reads of registers without side effects.
    let (status, address) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).mmfar.read()) };
    GUARD.has_overflowed(status, address)
}
