//! Gauss-Legendre rules, computed once.
//!
//! Nodes are the zeros of the Legendre polynomial, by Newton from `cos(pi (i + 3/4) / (n + 1/2))`;
//! weights `2 / ((1 - x^2) P'(x)^2)` (Abramowitz and Stegun 25.4.29).

use std::f64::consts::PI;
use std::sync::LazyLock;

/// Number of nodes of each [`half`] rule, and the largest exponent A for which it is accurate to
/// round-off (test `node_counts_suffice`).
pub(super) const HALF_RULES: [(usize, f64); 7] =
    [(6, 0.03), (8, 0.35), (10, 1.3), (12, 2.7), (14, 6.0), (16, 12.0), (20, f64::INFINITY)];

/// Node of a quadrature rule.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// Abscissa, from 0 to 1.
    pub(crate) at: f64,
    /// Weight.
    pub(crate) weight: f64,
}

static HALVES: LazyLock<[Vec<Node>; 7]> = LazyLock::new(|| {
    // Of the 2 n nodes on [-1, 1], the n below zero, shifted to [0, 1].
    HALF_RULES.map(|(nodes, _)| (0..nodes).map(|i| node(2 * nodes, i)).map(|(x, w)| Node { at: 1.0 - x, weight: w }).collect())
});

static WHOLE: LazyLock<Vec<Node>> =
    LazyLock::new(|| (0..40).map(|i| node(40, i)).map(|(x, w)| Node { at: 0.5 * (1.0 - x), weight: 0.5 * w }).collect());

/// Returns the half from 0 to 1 of a rule over 0 to 2, for integrands that are even about 1 and
/// decay from 0 to 1 as `exp(-A ...)`.
#[inline]
pub(crate) fn half(exponent: f64) -> &'static [Node] {
    &HALVES[rule(exponent)]
}

/// Returns the index in [`HALF_RULES`] for an exponent.
#[inline]
fn rule(exponent: f64) -> usize {
    HALF_RULES.iter().position(|rule| exponent <= rule.1).unwrap_or(HALF_RULES.len() - 1)
}

/// Returns a rule of 40 nodes over 0 to 1.
pub(crate) fn whole() -> &'static [Node] {
    &WHOLE
}

/// Returns zero number `i` of the Legendre polynomial of degree `n`, counted from +1 down, and its
/// weight.
pub(crate) fn node(n: usize, i: usize) -> (f64, f64) {
    let degree = n as f64;
    let mut x = (PI * (i as f64 + 0.75) / (degree + 0.5)).cos();
    let mut slope = 1.0;
    for _ in 0..6 {
        let (mut before, mut now) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (before, now) = (now, ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k);
        }
        slope = degree * (x * now - before) / (x * x - 1.0);
        x -= now / slope;
    }
    (x, 2.0 / ((1.0 - x * x) * slope * slope))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_polynomials_of_their_degree() {
        // The integral of x^k over 0 to 1 is 1 / (k + 1).
        for k in [0, 1, 2, 13, 40, 79] {
            let sum: f64 = whole().iter().map(|node| node.weight * node.at.powi(k)).sum();
            assert!((sum - 1.0 / f64::from(k + 1)).abs() < 1e-15, "{k}: {sum}");
        }
        // By symmetry, the integral of (1 - x)^(2 k) over half the rule is 1 / (2 k + 1).
        for (nodes, exponent) in HALF_RULES {
            let rule = half(exponent);
            assert_eq!(rule.len(), nodes);
            for k in 0..(2 * nodes as i32) {
                let sum: f64 = rule.iter().map(|node| node.weight * (1.0 - node.at).powi(2 * k)).sum();
                assert!((sum - 1.0 / f64::from(2 * k + 1)).abs() < 2e-15, "{nodes} {k}: {sum}");
            }
        }
    }
}
