//! Chebyshev polynomials of degree 11 on panels: coefficients from values at the zeros of the next
//! polynomial, values and slopes by Clenshaw's recurrence.
//!
//! The functions are smooth in the square root of the distance from a [`Corner`]; the panels divide
//! the range of that root.

use std::f64::consts::PI;
use std::sync::LazyLock;

/// Number of coefficients of a panel.
pub(super) const TERMS: usize = 12;

/// Chebyshev polynomials of each degree at the sampling points of a panel.
static COSINES: LazyLock<[[f64; TERMS]; TERMS]> = LazyLock::new(|| {
    std::array::from_fn(|degree| std::array::from_fn(|i| (PI * degree as f64 * (i as f64 + 0.5) / TERMS as f64).cos()))
});

/// Point at which functions have square-root singularities, and the range in which they are
/// resolved: `x = at + reach s^2`, s from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    pub(super) at: f64,
    pub(super) reach: f64,
}

impl Corner {
    /// Returns two corners that share the range between two points, in order.
    pub(super) fn between(from: f64, to: f64) -> [Corner; 2] {
        let reach = 0.5 * (to - from);
        [Corner { at: from, reach }, Corner { at: to, reach: -reach }]
    }

    /// Returns x at s.
    pub(super) fn x(&self, s: f64) -> f64 {
        self.at + self.reach * s * s
    }

    /// Returns s at x.
    pub(super) fn s(&self, x: f64) -> f64 {
        ((x - self.at) / self.reach).max(0.0).sqrt()
    }
}

/// Panel at a corner, over a range of s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Panel<const N: usize> {
    pub(super) corner: Corner,
    pub(super) from: f64,
    pub(super) to: f64,
    /// Coefficients of each function.
    pub(super) terms: [[f64; TERMS]; N],
}

impl<const N: usize> Panel<N> {
    /// Returns the larger x of both ends.
    pub(super) fn upper(&self) -> f64 {
        self.corner.x(if self.corner.reach > 0.0 { self.to } else { self.from })
    }

    /// Returns the s of the end with the smaller x.
    pub(super) fn lower_s(&self) -> f64 {
        if self.corner.reach > 0.0 { self.from } else { self.to }
    }

    /// Returns the position of s in the panel, from -1 to 1.
    fn within(&self, s: f64) -> f64 {
        ((s - self.from) - (self.to - s)) / (self.to - self.from)
    }

    /// Returns the value of a function at s.
    pub(super) fn value(&self, which: usize, s: f64) -> f64 {
        value(&self.terms[which], self.within(s))
    }

    /// Returns the values of two functions, with their slopes over s.
    pub(super) fn values_and_slopes(&self, which: [usize; 2], s: f64) -> [(f64, f64); 2] {
        let per_s = 2.0 / (self.to - self.from);
        values_and_slopes(which.map(|which| &self.terms[which]), self.within(s)).map(|(value, slope)| (value, per_s * slope))
    }
}

/// Criteria for halving a panel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Largest permitted last coefficient of a panel.
    pub(super) tail: f64,
    /// Width of the narrowest panel, in s.
    pub(super) narrowest: f64,
}

/// Appends panels of functions between two points, in order, halved until their last coefficients
/// are small.
pub(super) fn fill<const N: usize>(
    f: &impl Fn(f64) -> [f64; N],
    (from, to): (f64, f64),
    limits: Limits,
    panels: &mut Vec<Panel<N>>,
) {
    let [first, second] = Corner::between(from, to);
    halve(f, first, (0.0, 1.0), limits, panels);
    let turned = panels.len();
    halve(f, second, (0.0, 1.0), limits, panels);
    panels[turned..].reverse();
}

fn halve<const N: usize>(
    f: &impl Fn(f64) -> [f64; N],
    corner: Corner,
    (from, to): (f64, f64),
    limits: Limits,
    panels: &mut Vec<Panel<N>>,
) {
    let middle = 0.5 * (from + to);
    let found: [[f64; N]; TERMS] = std::array::from_fn(|i| f(corner.x(middle + 0.5 * (to - from) * COSINES[1][i])));
    let terms = std::array::from_fn(|which| coefficients(&found.map(|values| values[which])));
    if terms.iter().map(tail).fold(0.0, f64::max) > limits.tail && to - from > limits.narrowest {
        halve(f, corner, (from, middle), limits, panels);
        halve(f, corner, (middle, to), limits, panels);
    } else {
        panels.push(Panel { corner, from, to, terms });
    }
}

/// Returns the coefficients of a function from its values at the sampling points of a panel.
fn coefficients(found: &[f64; TERMS]) -> [f64; TERMS] {
    let cosines = &*COSINES;
    std::array::from_fn(|degree| {
        let scale = if degree == 0 { 1.0 } else { 2.0 } / TERMS as f64;
        scale * found.iter().zip(&cosines[degree]).map(|(value, cosine)| value * cosine).sum::<f64>()
    })
}

/// Returns the largest of the last coefficients.
fn tail(terms: &[f64; TERMS]) -> f64 {
    terms[TERMS - 3..].iter().fold(0.0, |most: f64, term| most.max(term.abs()))
}

/// Returns the value at t, -1 to 1.
fn value(terms: &[f64; TERMS], t: f64) -> f64 {
    let (b1, b2) = terms[1..].iter().rev().fold((0.0, 0.0), |(b1, b2), term| (term + 2.0 * t * b1 - b2, b1));
    terms[0] + t * b1 - b2
}

/// Returns values and slopes of two series at t, -1 to 1, computed together.
fn values_and_slopes(terms: [&[f64; TERMS]; 2], t: f64) -> [(f64, f64); 2] {
    let (mut b1, mut b2, mut d1, mut d2) = ([0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]);
    for degree in (1..TERMS).rev() {
        for i in 0..2 {
            (d1[i], d2[i]) = (2.0 * (b1[i] + t * d1[i]) - d2[i], d1[i]);
            (b1[i], b2[i]) = (terms[i][degree] + 2.0 * t * b1[i] - b2[i], b1[i]);
        }
    }
    std::array::from_fn(|i| (terms[i][0] + t * b1[i] - b2[i], b1[i] + t * d1[i] - d2[i]))
}
