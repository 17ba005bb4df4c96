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

/// `value` between `low` and `high`; a not-a-number is `low`. A `clamp` would panic where the ends are the wrong way round, or none.
#[inline]
pub(crate) fn within(value: f32, low: f32, high: f32) -> f32 {
    smaller(larger(value, low), high)
}

/// `value` between zero and `limit`; a not-a-number, which an order might carry, is zero.
pub(crate) fn up_to(limit: f32, value: f32) -> f32 {
    match value {
        value if value > limit => limit,
        value if value > 0.0 => value,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_the_ends_are_there_is_a_value() {
        assert_eq!([-3.0, 0.5, 3.0].map(|value| within(value, -1.0, 2.0)), [-1.0, 0.5, 2.0]);
        assert_eq!(within(f32::NAN, -1.0, 2.0), -1.0);
        // Where `clamp` would panic.
        assert_eq!([(2.0, -1.0), (f32::NAN, -1.0), (f32::NAN, 4.0)].map(|(low, high)| within(0.0, low, high)), [-1.0, -1.0, 4.0]);
        assert!(within(0.0, 1.0, f32::NAN).is_nan());
    }
}
