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

/// `value` between zero and `limit`; a not-a-number, which an order might carry, is zero.
pub(crate) fn up_to(limit: f32, value: f32) -> f32 {
    match value {
        value if value > limit => limit,
        value if value > 0.0 => value,
        _ => 0.0,
    }
}
