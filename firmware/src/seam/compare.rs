//! The larger and the smaller of two numbers, in an instruction or two: `f32::max` and `f32::min` are calls on the target, which count in a block, and
//! `f32::clamp` can panic.

/// The larger of two numbers; the second where the first is none.
#[inline]
pub(crate) fn larger(x: f32, y: f32) -> f32 {
    if x > y { x } else { y }
}

/// The smaller of two numbers; the second where the first is none.
#[inline]
pub(crate) fn smaller(x: f32, y: f32) -> f32 {
    if x < y { x } else { y }
}
