//! The guard below the stack: a part of the RAM without access, so that a stack that grows too far is a fault and not a changed variable.
//!
//! ```text
//! 0x2000_0000  static memory | 0x2000_8000  guard, 16 KiB | 0x2000_c000  stack, 48 KiB | 0x2001_8000
//! ```
//!
//! The guard is larger than any frame of the image, so that no frame can step over it. ARM DDI 0403 B3.5 (memory protection unit) and B3.2.15
//! (CFSR). The unit is off in the hard fault handler (MPU_CTRL.HFNMIENA = 0), which can therefore go on with the stack inside the guard.

/// Where the guard begins. The linker script refuses static memory beyond (`ccmram.x`).
pub const GUARD: u32 = 0x2000_8000;
/// Bytes of the guard: a power of two, to which the guard is aligned.
pub const GUARD_SIZE: u32 = 16 << 10;

/// MPU_RASR: a region of this size that no access is permitted to (AP = 0), and that holds no code (XN).
pub const fn attributes() -> u32 {
    const EXECUTE_NEVER: u32 = 1 << 28;
    const ENABLE: u32 = 1;
    // SIZE: the region has two to the power of SIZE + 1 bytes.
    EXECUTE_NEVER | (GUARD_SIZE.trailing_zeros() - 1) << 1 | ENABLE
}

/// Whether a fault is one of the stack: CFSR and MMFAR as the hard fault handler reads them.
pub fn has_overflowed(status: u32, address: u32) -> bool {
    const DATA_ACCESS: u32 = 1 << 1;
    const STACKING: u32 = 1 << 4;
    const LAZY_STACKING: u32 = 1 << 5;
    const ADDRESS_VALID: u32 = 1 << 7;
    let is_access = status & DATA_ACCESS != 0 && status & ADDRESS_VALID != 0 && address.wrapping_sub(GUARD) < GUARD_SIZE;
    is_access || status & (STACKING | LAZY_STACKING) != 0
}
