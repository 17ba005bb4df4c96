//! Guard below the stack of this board.
//!
//! ```text
//! 0x2000_0000  static memory | 0x2000_8000  guard, 16 KiB | 0x2000_c000  stack, 48 KiB | 0x2001_8000
//! ```

use boards_common::stack_guard::StackGuard;

/// Guard region. The linker script refuses static memory that extends into it (`ccmram.x`).
pub const GUARD: StackGuard = StackGuard::new(0x2000_8000, 16 << 10);
