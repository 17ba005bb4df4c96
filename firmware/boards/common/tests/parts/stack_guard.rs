//! Guard region below the stack.

use boards_common::stack_guard::StackGuard;

const GUARD: StackGuard = StackGuard::new(0x2000_8000, 16 << 10);

#[test]
fn the_guard_is_a_region_without_access() {
    // SIZE = 13 for 2^(13 + 1) bytes, AP = 0, XN, enabled.
    assert_eq!((GUARD.start(), GUARD.end(), GUARD.attributes()), (0x2000_8000, 0x2000_c000, 0x1000_001b));
    // The smallest region: SIZE = 4.
    assert_eq!(StackGuard::new(0x2400_0020, 32).attributes(), 0x1000_0009);
}

#[test]
fn only_a_fault_at_the_guard_or_while_stacking_is_an_overflow() {
    let (access, valid, stacking, lazy) = (1 << 1, 1 << 7, 1 << 4, 1 << 5);
    assert!(GUARD.has_overflowed(access | valid, GUARD.start()) && GUARD.has_overflowed(access | valid, GUARD.end() - 4));
    assert!(GUARD.has_overflowed(stacking, 0) && GUARD.has_overflowed(lazy, 0));
    for (status, address) in [
        (0, GUARD.start()),
        (access, GUARD.start()),
        (access | valid, GUARD.start() - 4),
        (access | valid, GUARD.end()),
        (1, GUARD.start()),
    ] {
        assert!(!GUARD.has_overflowed(status, address), "{status:#x} {address:#x}");
    }
}
