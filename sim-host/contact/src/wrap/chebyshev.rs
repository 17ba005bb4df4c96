//! Chebyshev polynomials of degree 11 on panels: coefficients by values at the zeros of the next one, values and slopes by Clenshaw's recurrence.
//!
//! The functions here are smooth over the square root of the distance from a [`Corner`], of which the panels are parts.

use std::f64::consts::PI;
use std::sync::LazyLock;

/// Coefficients of a panel.
pub(super) const TERMS: usize = 12;

/// Polynomials of each degree at the places of a panel at which a function is known.
static COSINES: LazyLock<[[f64; TERMS]; TERMS]> = LazyLock::new(|| {
    std::array::from_fn(|degree| std::array::from_fn(|i| (PI * degree as f64 * (i as f64 + 0.5) / TERMS as f64).cos()))
});

/// A place at which a function has roots, and the way to where it has none: `x = at + reach s^2`, s from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    pub(super) at: f64,
    pub(super) reach: f64,
}

impl Corner {
    /// Two corners that share what is between two places, in order.
    pub(super) fn between(from: f64, to: f64) -> [Corner; 2] {
        let reach = 0.5 * (to - from);
        [Corner { at: from, reach }, Corner { at: to, reach: -reach }]
    }

    /// What is at s.
    pub(super) fn x(&self, s: f64) -> f64 {
        self.at + self.reach * s * s
    }

    /// Where x is.
    pub(super) fn s(&self, x: f64) -> f64 {
        ((x - self.at) / self.reach).max(0.0).sqrt()
    }
}

/// A panel from a corner, from one s to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Panel<const N: usize> {
    pub(super) corner: Corner,
    pub(super) from: f64,
    pub(super) to: f64,
    /// Coefficients of each function.
    pub(super) terms: [[f64; TERMS]; N],
}

impl<const N: usize> Panel<N> {
    /// The larger x of its ends.
    pub(super) fn upper(&self) -> f64 {
        self.corner.x(if self.corner.reach > 0.0 { self.to } else { self.from })
    }

    /// The s at which x is smaller.
    pub(super) fn lower_s(&self) -> f64 {
        if self.corner.reach > 0.0 { self.from } else { self.to }
    }

    /// Where s is in the panel, from -1 to 1.
    fn within(&self, s: f64) -> f64 {
        ((s - self.from) - (self.to - s)) / (self.to - self.from)
    }

    /// Value of a function at s.
    pub(super) fn value(&self, which: usize, s: f64) -> f64 {
        value(&self.terms[which], self.within(s))
    }

    /// Values of two functions, with their slopes over s.
    pub(super) fn values_and_slopes(&self, which: [usize; 2], s: f64) -> [(f64, f64); 2] {
        let per_s = 2.0 / (self.to - self.from);
        values_and_slopes(which.map(|which| &self.terms[which]), self.within(s)).map(|(value, slope)| (value, per_s * slope))
    }
}

/// When panels are narrow enough.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// The last coefficients of a panel at most.
    pub(super) tail: f64,
    /// The narrowest panel, of s.
    pub(super) narrowest: f64,
}

/// Panels of functions between two places, in order, halved until their last coefficients are small.
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

/// Coefficients of a function by its values at the places of a panel.
fn coefficients(found: &[f64; TERMS]) -> [f64; TERMS] {
    let cosines = &*COSINES;
    std::array::from_fn(|degree| {
        let scale = if degree == 0 { 1.0 } else { 2.0 } / TERMS as f64;
        scale * found.iter().zip(&cosines[degree]).map(|(value, cosine)| value * cosine).sum::<f64>()
    })
}

/// The largest of the last coefficients.
fn tail(terms: &[f64; TERMS]) -> f64 {
    terms[TERMS - 3..].iter().fold(0.0, |most: f64, term| most.max(term.abs()))
}

/// Value at a place, -1 to 1.
fn value(terms: &[f64; TERMS], t: f64) -> f64 {
    let (b1, b2) = terms[1..].iter().rev().fold((0.0, 0.0), |(b1, b2), term| (term + 2.0 * t * b1 - b2, b1));
    terms[0] + t * b1 - b2
}

/// Values and slopes of two series at a place, -1 to 1, abreast.
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
