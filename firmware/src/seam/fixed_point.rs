//! Fixed-point products: the upper half of 64 bits, in one cycle of a Cortex-M4 and identical on
//! every target.

/// Returns `a b / 2^32`, rounded down (`SMMUL`; with a sum, `SMMLA`).
#[inline(always)]
pub(crate) fn upper(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 32) as i32
}

/// Returns `a b / 2^32`, rounded to the nearest (`SMMULR`).
#[inline(always)]
pub(crate) fn nearest(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b) + (1 << 31)) >> 32) as i32
}
