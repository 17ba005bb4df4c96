//! Minimum, maximum and clamp in an instruction or two. On the target `f32::max` and `f32::min` are
//! calls, which cost time in a block, and `f32::clamp` can panic.

/// Returns the larger of two numbers; `y` if `x` is not a number.
#[inline]
pub(crate) fn larger(x: f32, y: f32) -> f32 {
    if x > y { x } else { y }
}

/// Returns the smaller of two numbers; `y` if `x` is not a number.
#[inline]
pub(crate) fn smaller(x: f32, y: f32) -> f32 {
    if x < y { x } else { y }
}

/// Returns `value` clamped to `low..=high`; `low` if it is not a number. `clamp` would panic if
/// `low > high` or one of them is not a number.
#[inline]
pub(crate) fn within(value: f32, low: f32, high: f32) -> f32 {
    smaller(larger(value, low), high)
}

/// Returns `value` clamped to zero and `limit`; zero if an order carries a value that is not a
/// number.
pub(crate) fn up_to(limit: f32, value: f32) -> f32 {
    match value {
        value if value > limit => limit,
        value if value > 0.0 => value,
        _ => 0.0,
    }
}

/// Change of the drive from block to block that is a step, relative.
const STEP_REL: f32 = 0.05;

/// Returns `true` if the drive has been stepped between two blocks: phasors before and after a step
/// cannot be compared.
#[inline]
pub(crate) fn is_step(before_v: f32, now_v: f32) -> bool {
    (now_v - before_v).abs() > STEP_REL * now_v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn within_returns_a_value_for_any_bounds() {
        assert_eq!([-3.0, 0.5, 3.0].map(|value| within(value, -1.0, 2.0)), [-1.0, 0.5, 2.0]);
        assert_eq!(within(f32::NAN, -1.0, 2.0), -1.0);
        // Here `clamp` would panic.
        assert_eq!([(2.0, -1.0), (f32::NAN, -1.0), (f32::NAN, 4.0)].map(|(low, high)| within(0.0, low, high)), [-1.0, -1.0, 4.0]);
        assert!(within(0.0, 1.0, f32::NAN).is_nan());
    }
}
