//! Guard below the stack: a region of the RAM without access, so that a stack overflow causes a
//! fault instead of overwriting variables.
//!
//! ```text
//! static memory | ... | guard | stack |
//! ```
//!
//! The guard must be larger than any stack frame of the image, so that no frame can skip it. It is
//! a region of the memory protection unit of ARMv7-M (Cortex-M3, M4, M7): ARM DDI 0403 B3.5 (memory
//! protection unit) and B3.2.15 (CFSR). The unit must be off in the hard fault handler
//! (MPU_CTRL.HFNMIENA = 0); the handler can then use the stack inside the guard. ARMv8-M
//! (Cortex-M33) has a register for the stack limit and needs no guard.

/// Guard region below the stack: start address and size in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StackGuard {
    start: u32,
    size: u32,
}

impl StackGuard {
    /// Creates a guard of `size` bytes at address `start`.
    ///
    /// # Panics
    ///
    /// Panics if the size is not a power of two of at least 32, or if the start is not a multiple
    /// of the size.
    #[inline]
    pub const fn new(start: u32, size: u32) -> Self {
        assert!(
            size >= 32 && size.is_power_of_two() && start.is_multiple_of(size),
            "not a valid region of the memory protection unit"
        );
        StackGuard { start, size }
    }

    /// Returns the first address of the guard.
    #[inline]
    pub const fn start(&self) -> u32 {
        self.start
    }

    /// Returns the end of the guard, which is the lowest address of the stack.
    #[inline]
    pub const fn end(&self) -> u32 {
        self.start + self.size
    }

    /// Returns the value of MPU_RASR: a region of this size without access (AP = 0) and without
    /// code (XN).
    #[inline]
    pub const fn attributes(&self) -> u32 {
        const EXECUTE_NEVER: u32 = 1 << 28;
        const ENABLE: u32 = 1;
        // SIZE: the region has 2^(SIZE + 1) bytes.
        EXECUTE_NEVER | (self.size.trailing_zeros() - 1) << 1 | ENABLE
    }

    /// Returns `true` if a fault is a stack overflow, from CFSR and MMFAR as read by the hard fault
    /// handler.
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
