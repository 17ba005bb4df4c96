//! The guard below the stack: a part of the RAM without access, so that a stack that grows too far
//! is a fault and not a changed variable.
//!
//! ```text
//! static memory | ... | guard | stack |
//! ```
//!
//! The guard has to be larger than any frame of the image, so that no frame can step over it. It is
//! a region of the memory protection unit of ARMv7-M (Cortex-M3, M4, M7): ARM DDI 0403 B3.5 (memory
//! protection unit) and B3.2.15 (CFSR). The unit has to be off in the hard fault handler
//! (MPU_CTRL.HFNMIENA = 0), which can therefore go on with the stack inside the guard. ARMv8-M
//! (Cortex-M33) has a register for the limit of the stack instead, and needs no guard.

/// A guard: where it begins, and its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StackGuard {
    start: u32,
    size: u32,
}

impl StackGuard {
    /// A guard of so many bytes from an address on: a power of two of 32 at least, to which the
    /// address is aligned.
    #[inline]
    pub const fn new(start: u32, size: u32) -> Self {
        assert!(size >= 32 && size.is_power_of_two() && start.is_multiple_of(size), "a region of the memory protection unit");
        StackGuard { start, size }
    }

    /// Where the guard begins.
    #[inline]
    pub const fn start(&self) -> u32 {
        self.start
    }

    /// Where the guard ends, and the room of the stack begins.
    #[inline]
    pub const fn end(&self) -> u32 {
        self.start + self.size
    }

    /// MPU_RASR: a region of this size that no access is permitted to (AP = 0), and that holds no
    /// code (XN).
    #[inline]
    pub const fn attributes(&self) -> u32 {
        const EXECUTE_NEVER: u32 = 1 << 28;
        const ENABLE: u32 = 1;
        // SIZE: the region has two to the power of SIZE + 1 bytes.
        EXECUTE_NEVER | (self.size.trailing_zeros() - 1) << 1 | ENABLE
    }

    /// Whether a fault is one of the stack: CFSR and MMFAR as the hard fault handler reads them.
    #[inline]
    pub fn has_overflowed(&self, status: u32, address: u32) -> bool {
        const DATA_ACCESS: u32 = 1 << 1;
        const STACKING: u32 = 1 << 4;
        const LAZY_STACKING: u32 = 1 << 5;
        const ADDRESS_VALID: u32 = 1 << 7;
        let is_access = status & DATA_ACCESS != 0 && status & ADDRESS_VALID != 0 && address.wrapping_sub(self.start) < self.size;
        is_access || status & (STACKING | LAZY_STACKING) != 0
    }
}
