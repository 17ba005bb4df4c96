//! Polynomials over one step, `p(s) = sum of c[k] s^k` for s from 0 to 1: values, roots, and the
//! first reversal of a velocity.

use crate::forcing::INVERSE;

/// Returns the value at `s`, from the even and the odd part: two short chains instead of a long
/// one.
#[inline]
pub fn value<const N: usize>(c: &[f64; N], s: f64) -> f64 {
    let square = s * s;
    let part = |first: usize| every_second::<N, _>(first, |k| c[k], |sum, c| sum * square + c);
    part(0) + s * part(1)
}

/// Returns the slope at `s`.
#[inline]
pub fn slope<const N: usize>(c: &[f64; N], s: f64) -> f64 {
    let square = s * s;
    let part = |first: usize| every_second::<N, _>(first, |k| k as f64 * c[k], |sum, c| sum * square + c);
    part(1) + s * part(2)
}

/// Returns the integral from 0 to `s`.
#[inline]
pub fn integral<const N: usize>(c: &[f64; N], s: f64) -> f64 {
    let square = s * s;
    let part = |first: usize| every_second::<N, _>(first, |k| c[k] * INVERSE[k], |sum, c| sum * square + c);
    (part(0) + s * part(1)) * s
}

/// Combines every second one of `N` terms, from the last down to `first`; zero if there is none.
/// A loop over indices, which the compiler unrolls; it does not unroll one over iterators.
#[inline(always)]
pub(super) fn every_second<const N: usize, T: Default>(first: usize, term: impl Fn(usize) -> T, add: impl Fn(T, T) -> T) -> T {
    if N <= first {
        return T::default();
    }
    let mut k = N - 1 - (N - 1 - first) % 2;
    let mut sum = term(k);
    while k >= first + 2 {
        k -= 2;
        sum = add(sum, term(k));
    }
    sum
}

/// Returns the product, truncated to the same number of coefficients.
#[inline]
pub fn product<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|k| (0..=k).map(|j| a[j] * b[k - j]).sum())
}

/// Returns the slope as a polynomial.
fn derivative<const N: usize>(c: &[f64; N]) -> [f64; N] {
    let mut slopes = [0.0; N];
    for k in 1..N {
        slopes[k - 1] = c[k] * k as f64;
    }
    slopes
}

/// Position with the value and the slope there.
#[derive(Clone, Copy)]
struct Point {
    at: f64,
    value: f64,
    slope: f64,
}

/// Largest ratio of two successive steps that indicates quadratic convergence.
pub(super) const QUADRATIC_STEP_RATIO: f64 = 0.2;

/// Finds the root between a point and `high`, at which the polynomial has the value `last` of
/// opposite sign: Newton's method inside a bracket.
///
/// It begins on the parabola through both values with the slope at the point. It ends with a step
/// shorter than `enough`, so that the error is of the order of its square. Near a double root,
/// where convergence is not quadratic, it ends with a step shorter than that square.
fn root<const N: usize>(c: &[f64; N], from: Point, high: f64, last: f64, enough: f64) -> f64 {
    let (mut low, mut high, first) = (from.at, high, from.value);
    let (falls, steep) = (first > 0.0, from.slope * (high - low));
    let bend = last - first - steep;
    // first + steep p + bend p^2 = 0. As the values differ in sign, one root is inside: either the
    // one with the larger denominator, or the other.
    let under = (steep * steep - 4.0 * bend * first).max(0.0).sqrt().copysign(steep);
    let far = -0.5 * (steep + under);
    let inside = |part: &f64| *part > 0.0 && *part < 1.0;
    let part = Some(first / far).filter(inside).or(Some(far / bend).filter(inside)).unwrap_or(0.5);
    let mut s = low + (high - low) * part;
    let slopes = derivative(c);
    let mut before = f64::INFINITY;
    for _ in 0..80 {
        let here = value(c, s);
        if (here > 0.0) == falls {
            low = s
        } else {
            high = s
        }
        let newton = s - here / value(&slopes, s);
        // At the root itself round-off decides the side, and Newton's step ends on the edge of the
        // bracket. This counts as inside.
        let inside = newton >= low && newton <= high;
        let next = if inside { newton } else { 0.5 * (low + high) };
        let step = (next - s).abs();
        let squares = step <= QUADRATIC_STEP_RATIO * before || step <= enough * enough;
        if inside && step <= enough && squares || high - low <= 2e-16 {
            return next;
        }
        (s, before) = (next, step);
    }
    s
}

/// Number of sections of a step that are searched one by one; within a section a velocity turns at
/// most once.
pub(super) const SECTIONS: u32 = 2;

/// Returns the first moment of the step at which a velocity of sign `sense` crosses zero.
///
/// The initial sign is `sense`, never the round-off of a velocity that is zero there. A velocity
/// that dips below zero and returns within the step reverses, too. To find such a dip, the minimum
/// is located instead of checking the ends only.
///
/// The moment is accurate to the square of `enough`, as a fraction of the step.
pub fn first_reversal<const N: usize>(velocity: &[f64; N], sense: f64, enough: f64) -> Option<f64> {
    let begin = Point { at: 0.0, value: velocity[0], slope: velocity.get(1).copied().unwrap_or(0.0) };
    let end = value(velocity, 1.0);
    if sense * end < 0.0 {
        return Some(crossing(velocity, sense, begin, (1.0, end), enough));
    }
    // No term can lower the value by more than its own size.
    let fall: f64 = velocity.iter().skip(1).map(|c| (sense * c).min(0.0)).sum();
    if sense * velocity[0] + fall > 0.0 {
        return None;
    }
    let at = |s: f64| sense * value(velocity, s);
    let mut low = begin;
    for part in 1..=SECTIONS {
        let at_s = f64::from(part) / f64::from(SECTIONS);
        let high = Point { at: at_s, value: value(velocity, at_s), slope: slope(velocity, at_s) };
        if sense * high.value < 0.0 {
            return Some(crossing(velocity, sense, low, (at_s, high.value), enough));
        }
        if sense * low.slope < 0.0 && sense * high.slope > 0.0 {
            let bend = derivative(velocity);
            let turn = Point { at: low.at, value: low.slope, slope: slope(&bend, low.at) };
            // The depth of a grazing dip depends on its position, which must be accurate to
            // round-off.
            let bottom = root(&bend, turn, high.at, high.slope, 1e-8);
            if at(bottom) < 0.0 {
                return Some(crossing(velocity, sense, low, (bottom, value(velocity, bottom)), enough));
            }
        }
        low = high;
    }
    None
}

/// Returns the root in a bracket whose upper end is beyond it and whose lower end may itself be a
/// root.
fn crossing<const N: usize>(velocity: &[f64; N], sense: f64, low: Point, (high, last): (f64, f64), enough: f64) -> f64 {
    let (mut above, mut width) = (low, high - low.at);
    while sense * above.value <= 0.0 {
        width *= 0.5;
        if width < 1e-15 {
            // The velocity has the other sign from the beginning.
            return low.at;
        }
        let at = low.at + width;
        above = Point { at, value: value(velocity, at), slope: slope(velocity, at) };
    }
    root(velocity, above, high, last, enough)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reversals_are_located() {
        // (0.3 - s)(0.7 - s)
        let twice = [0.21, -1.0, 1.0];
        assert!((first_reversal(&twice, 1.0, 1e-8).unwrap() - 0.3).abs() < 1e-15);
        // Starts at a root, rises, and falls through 0.6.
        let arch = [0.0, 0.6, -1.0];
        assert!((first_reversal(&arch, 1.0, 1e-8).unwrap() - 0.6).abs() < 1e-15);
        // Round-off of the wrong sign at the beginning is not a reversal.
        assert_eq!(first_reversal(&[-1e-18, 0.5, 0.1], 1.0, 1e-8), None);
        assert_eq!(first_reversal(&[0.0, 0.5, 0.1], 1.0, 1e-8), None);
        // A fall from zero is a reversal at once.
        assert_eq!(first_reversal(&[0.0, -0.5, 0.1], 1.0, 1e-8), Some(0.0));
    }

    #[test]
    fn a_dip_inside_the_step_is_found() {
        for depth in [1e-3, 1e-6, 1e-9, 1e-12] {
            // (s - 0.55)^2 - depth
            let c = [0.3025 - depth, -1.1, 1.0];
            let found = first_reversal(&c, 1.0, 1e-8).unwrap();
            assert!((found - (0.55 - depth.sqrt())).abs() < 1e-9, "{depth}: {found}");
        }
        assert_eq!(first_reversal(&[0.3025 + 1e-12, -1.1, 1.0], 1.0, 1e-8), None);
    }

    #[test]
    fn products_and_integrals() {
        let p = product(&[1.0, 2.0, 0.0, 0.0], &[3.0, 0.0, 1.0, 0.0]);
        assert_eq!(p, [3.0, 6.0, 1.0, 2.0]);
        assert!((integral(&p, 0.5) - (1.5 + 0.75 + 1.0 / 24.0 + 1.0 / 32.0)).abs() < 1e-15);
    }
}
