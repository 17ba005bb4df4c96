//! The first position at which a polynomial becomes negative.
//!
//! An interval of half width w about c contains no zero if `p(c) > |p'(c)| w + M w^2 / 2`, and is
//! monotone if `|p'(c)| > M w`, where M bounds the second derivative on [0, 1]. If neither is known
//! to hold, the interval is split. A zero that only touches is therefore passed over, and two close
//! together are not missed.

use super::arc::value;

/// Width below which an interval is not split; two zeros closer together have no effect.
const NARROWEST_INTERVAL: f64 = 1e-9;

/// Returns the first fraction in (0, 1] at which the polynomial becomes negative. Its first `zeros`
/// coefficients count as zero.
pub(super) fn first(series: &[f64], zeros: usize) -> Option<f64> {
    // Dividing by the known powers removes the zero at the beginning. An all-zero polynomial never
    // becomes negative; it would be split without end.
    let known = zeros + series.get(zeros..)?.iter().position(|&c| c != 0.0)?;
    let polynomial = series.get(known..)?;
    if *polynomial.first()? < 0.0 {
        return Some(0.0);
    }
    let curvature: f64 = polynomial.iter().enumerate().map(|(k, c)| (k * k.saturating_sub(1)) as f64 * c.abs()).sum();
    // Intervals are searched from left to right; the next one is at the end of the list.
    let mut intervals = vec![(0.0, 1.0)];
    while let Some((from, to)) = intervals.pop() {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let (p, slope) = with_slope(polynomial, middle);
        if p > slope.abs() * half + 0.5 * curvature * half * half {
            continue;
        }
        let monotone = slope.abs() > curvature * half;
        if monotone || half < NARROWEST_INTERVAL {
            if value(polynomial, to) < 0.0 {
                return Some(locate(polynomial, from, to));
            }
        } else {
            intervals.push((middle, to));
            intervals.push((from, middle));
        }
    }
    None
}

/// Locates the zero between a position that is not below zero and one that is: Newton's method,
/// bracketed by bisection.
fn locate(polynomial: &[f64], mut from: f64, mut to: f64) -> f64 {
    let mut at = 0.5 * (from + to);
    for _ in 0..80 {
        let (p, slope) = with_slope(polynomial, at);
        if p < 0.0 {
            to = at;
        } else {
            from = at;
        }
        let newton = at - p / slope;
        let next = if newton > from && newton < to { newton } else { 0.5 * (from + to) };
        if (next - at).abs() <= 2.0 * f64::EPSILON * at {
            return next;
        }
        at = next;
    }
    at
}

fn with_slope(polynomial: &[f64], at: f64) -> (f64, f64) {
    polynomial.iter().rev().fold((0.0, 0.0), |(p, slope), c| (p * at + c, slope * at + p))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the coefficients of the product of (t - root).
    fn with_roots(roots: &[f64]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |polynomial, root| {
            let mut out = vec![0.0; polynomial.len() + 1];
            for (k, c) in polynomial.iter().enumerate() {
                out[k + 1] += c;
                out[k] -= root * c;
            }
            out
        })
    }

    #[test]
    fn the_first_of_several_is_found() {
        for (roots, expected) in [
            (vec![0.3, 0.7], Some(0.3)),
            (vec![0.3, 0.300_001], Some(0.3)),
            (vec![0.999], Some(0.999)),
            (vec![1.2, 1.5], None),
            (vec![-0.5, 1.1], None),
            (vec![0.375, 0.375, 0.75], Some(0.75)),
            (vec![0.375, 0.375], None),
            (vec![0.25, 0.25, 0.25], Some(0.25)),
        ] {
            let mut polynomial = with_roots(&roots);
            if value(&polynomial, 0.0) < 0.0 {
                polynomial.iter_mut().for_each(|c| *c = -*c);
            }
            let got = first(&polynomial, 0);
            let near = if roots.len() == 3 { 1e-5 } else { 1e-9 };
            let same = match (got, expected) {
                (Some(got), Some(expected)) => (got - expected).abs() < near,
                (got, expected) => got == expected,
            };
            assert!(same, "{roots:?}: {got:?}");
        }
    }

    #[test]
    fn a_zero_at_the_beginning_does_not_count() {
        // t (0.5 - t) with round-off instead of its zero
        assert!((first(&[-1e-17, 0.5, -1.0], 1).unwrap() - 0.5).abs() < 1e-15);
        assert_eq!(first(&[-1e-17, 0.5, 1.0], 1), None);
        assert_eq!(first(&[0.0, -0.5, 1.0], 1), Some(0.0));
        assert_eq!(first(&[0.0, 0.0, -0.5, 1.0], 1), Some(0.0));
        assert!((first(&[0.0, 0.0, 0.5, -1.0], 1).unwrap() - 0.5).abs() < 1e-15);
    }

    /// Slip that stays zero to round-off, as under a square wave whose velocity equals the sliding.
    /// Without a special case it was split into 2^30 intervals.
    #[test]
    fn an_all_zero_polynomial_is_not_searched() {
        assert_eq!(first(&[2.8e-17, 0.0, -0.0, 0.0], 1), None);
        assert_eq!(first(&[0.0; 22], 0), None);
        assert_eq!(first(&[], 0), None);
    }
}
