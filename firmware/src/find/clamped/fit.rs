//! The elements of the [model](super::model) from admittances at some frequencies: Gauss and Newton's iteration, one admittance a block, then what is known
//! beforehand, then the solution. With two resonances, whose rows are longer, one part of an admittance a block.
//!
//! Started by a linear fit without losses (Levy 1959), so that no initial value of the resonance is needed: with `Z = Im Y / u`, `v = u^2 - 1`,
//!
//! ```text
//! one resonance:  Z v   = w Z - p + c v,              us^2 - 1 = w,  k = p - c w
//! two:            Z v^2 = -a Z v - b Z + c v^2 + e v + p,   us^2 - 1 and u2^2 - 1 the roots of v^2 + a v + b
//! ```
//!
//! What one resonance cannot explain is tried with two: with another one above, then from such a start, both as lossy as the first; where
//! neither explains it, with a loss of its own, from the best of these, or from one below. Two are taken for one only where they leave a third of what one
//! leaves: with nine or ten unknowns of sixteen numbers they always leave less.

use heapless::Vec;

use crate::find::clamped::model::{C, D, D2, Elements, G, H, K, K2, THETA, UNKNOWNS, X2, XS, admittance};
use crate::find::givens::RealTriangle;
use crate::seam::compare::within;
use crate::seam::phasor::Phasor;

/// The most admittances there can be.
pub(crate) const MAX_POINTS: usize = 8;
/// Iterations with one resonance, with two, and with two of which one has a loss of its own, for which there is the least time. They square the error from 1e-2 on, or
/// nearly so.
const ROUNDS: (u32, u32, u32) = (5, 8, 5);
/// Beyond this rms residual, in standard deviations, one resonance does not explain what was measured.
const MISFIT: f32 = 4.0;
/// Two resonances are taken where they leave less than this part of what one leaves.
const BETTER: f32 = 1.0 / 3.0;
/// Where a second resonance is looked for first, above and below the first, and how strong, relative to it.
const SECOND: (f32, f32) = (0.06, 0.15);
/// Priors: an element, and its standard deviation about zero. That of the loss is about the nominal loss, relative to it, that of a second resonance's about the first's; `theta`'s is a time, s, by which
/// the sense channels are apart.
const KNOWN: [(usize, f32); 5] = [(XS, 0.1), (D, 4.0), (THETA, 150e-9), (X2, 0.2), (D2, 1.0)];
/// The standard deviation of a second resonance's loss about the first's where they are taken to be the same, relative to it.
const ALIKE: f32 = 0.01;
/// How the loss of the clamped branch rises with the frequency: between that of a dielectric (1) and of images (2), and to what part of the
/// clamped susceptance that is known.
const LOSS_RISES: (f32, f32) = (1.5, 0.02);
/// The most that a resonance may move in one iteration, and the most that a loss, a strength or the clamped capacitance may change by, as a factor; the most
/// that sensing may turn, rad.
const LONGEST_STEP: f32 = 0.01;
const LARGEST_FACTOR: f32 = 3.0;
const LARGEST_THETA: f32 = 0.3;

/// An admittance, relative to the nominal clamped susceptance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// Offset from the nominal frequency, relative to it.
    pub(crate) x: f32,
    /// The admittance.
    pub(crate) y: Phasor,
    /// Its standard deviation, of either part.
    pub(crate) deviation: f32,
}

/// A part of an admittance.
type Part = fn(Phasor) -> f32;
const PARTS: [Part; 2] = [|y| y.re, |y| y.im];

/// What is fitted at present.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    StartOne,
    One,
    /// With a second resonance above the first.
    Above,
    /// With one as lossy as it may be.
    Free,
    StartTwo,
    Two,
}

/// Elements that explain the points, and how well.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solution {
    /// The elements.
    pub(crate) elements: Elements,
    /// Their triangular factor.
    pub(crate) triangle: RealTriangle<UNKNOWNS>,
    /// Root of what is left in the mean of the degrees of freedom, in standard deviations: one, if the model holds.
    pub(crate) misfit: f32,
}

impl Solution {
    /// Standard deviation of a sum of elements, larger where the model does not hold.
    pub(crate) fn deviation(&self, of: &[f32; UNKNOWNS]) -> f32 {
        self.triangle.deviation(of) * self.misfit.max(1.0)
    }
}

/// The fit, in progress.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    loss: f32,
    /// Angular nominal frequency, 1/s.
    omega: f32,
    points: Vec<Point, MAX_POINTS>,
    stage: Stage,
    round: u32,
    block: usize,
    elements: Elements,
    triangle: RealTriangle<UNKNOWNS>,
    best: Option<Solution>,
    /// What one resonance explains best.
    one: Elements,
}

impl Fit {
    /// Without a point. `loss`: the nominal one, `1 / Q`; the nominal frequency, Hz.
    pub(crate) fn new(loss: f32, nominal_hz: f32) -> Self {
        Fit {
            loss,
            omega: core::f32::consts::TAU * nominal_hz,
            points: Vec::new(),
            stage: Stage::StartOne,
            round: 0,
            block: 0,
            elements: Elements::default(),
            triangle: RealTriangle::default(),
            best: None,
            one: Elements::default(),
        }
    }

    /// Adds a point; no more than there is room for.
    pub(crate) fn add(&mut self, point: Point) {
        let _ = self.points.push(point);
    }

    /// What has been found, when it is over.
    pub(crate) fn solution(&self) -> Option<&Solution> {
        self.best.as_ref()
    }

    /// Does a block's worth of it. Returns whether it is over.
    pub(crate) fn advance(&mut self) -> bool {
        let starts = matches!(self.stage, Stage::StartOne | Stage::StartTwo);
        let blocks = if matches!(self.stage, Stage::Above | Stage::Free | Stage::Two) { 2 } else { 1 };
        let (row, part) = (self.block / blocks, self.block % blocks);
        self.block += 1;
        match self.points.get(row) {
            Some(&point) if starts => self.fold_linear(point),
            Some(&point) if blocks == 1 => self.fold(point, &PARTS),
            Some(&point) => self.fold(point, &PARTS[part..=part]),
            None if starts => {
                self.block = 0;
                self.start();
            }
            None if row == self.points.len() => {
                if part == 0 {
                    self.fold_known();
                }
                if part + 1 == blocks {
                    self.fold_loss();
                }
            }
            None => {
                self.block = 0;
                return self.finish_round();
            }
        }
        false
    }

    fn fold_linear(&mut self, point: Point) {
        let v = point.x * (2.0 + point.x);
        let z = point.y.im / (1.0 + point.x);
        let mut row = [0.0; UNKNOWNS];
        let (weight, right) = if self.stage == Stage::StartOne {
            row[..3].copy_from_slice(&[z, -1.0, v]);
            (1.0 / (v * point.deviation), z * v)
        } else {
            row[..5].copy_from_slice(&[-z * v, -z, v * v, v, 1.0]);
            (1.0 / (v * v * point.deviation), z * v * v)
        };
        self.triangle.fold(row.map(|x| x * weight), right * weight);
    }

    /// Folds parts of an admittance.
    fn fold(&mut self, point: Point, parts: &[Part]) {
        let (y, by) = admittance(&self.elements, point.x);
        let weight = 1.0 / point.deviation;
        let (left, unknown) = (point.y - y, if self.stage == Stage::One { K2 } else { UNKNOWNS });
        for part in parts {
            let row = core::array::from_fn(|n| if n < unknown { part(by[n]) * weight } else { 0.0 });
            self.triangle.fold_among(unknown, row, part(left) * weight);
        }
    }

    /// Begins the iteration where the linear fit has ended.
    fn start(&mut self) {
        let resonance = |w: f32| libm::sqrtf((1.0 + w).clamp(0.6, 1.6)) - 1.0;
        let mut e = Elements::default();
        e[D] = self.loss;
        if self.stage == Stage::StartOne {
            let [w, p, c, ..] = self.triangle.solve();
            (e[C], e[K], e[XS]) = (c, p - c * w, resonance(w));
            self.stage = Stage::One;
        } else {
            let [a, b, c, slope, p, ..] = self.triangle.solve();
            let apart = libm::sqrtf((a * a - 4.0 * b).max(1e-4));
            let roots = [0.5 * (-a - apart), 0.5 * (-a + apart)];
            let strength = |w: f32, other: f32| (c * w * w + slope * w + p) / (other - w);
            let strengths = [strength(roots[0], roots[1]), strength(roots[1], roots[0])];
            let main = usize::from(strengths[1] > strengths[0]);
            (e[C], e[K], e[XS]) = (c, strengths[main], resonance(roots[main]));
            (e[K2], e[X2], e[D2]) = (strengths[1 - main], resonance(roots[1 - main]), self.loss);
            self.stage = Stage::Two;
        }
        (self.elements, self.round) = (e, 0);
        self.triangle.restart();
    }

    fn fold_known(&mut self) {
        for (n, deviation) in KNOWN {
            let (expected, deviation) = match n {
                D => (self.loss, deviation * self.loss),
                THETA => (0.0, deviation * self.omega),
                X2 | D2 if self.stage == Stage::One => continue,
                D2 => (self.elements[D], if self.stage == Stage::Free { deviation } else { ALIKE } * self.elements[D]),
                _ => (0.0, deviation),
            };
            let mut row = core::array::from_fn(|k| if k == n { 1.0 / deviation } else { 0.0 });
            if n == D2 {
                row[D] = -row[D2];
            }
            let element = self.elements.get(n).copied().unwrap_or(expected);
            self.triangle.fold(row, (expected - element) / deviation);
        }
    }

    fn fold_loss(&mut self) {
        let mut rises = [0.0; UNKNOWNS];
        (rises[H], rises[G]) = (1.0 / LOSS_RISES.1, -LOSS_RISES.0 / LOSS_RISES.1);
        self.triangle.fold(rises, (LOSS_RISES.0 * self.elements[G] - self.elements[H]) / LOSS_RISES.1);
    }

    fn finish_round(&mut self) -> bool {
        for (n, (element, step)) in self.elements.iter_mut().zip(self.triangle.solve()).enumerate() {
            let before = *element;
            *element += step;
            match n {
                XS | X2 => *element = within(*element, before - LONGEST_STEP, before + LONGEST_STEP),
                THETA => *element = within(*element, -LARGEST_THETA, LARGEST_THETA),
                D | D2 | C | K if before > 0.0 => *element = within(*element, before / LARGEST_FACTOR, before * LARGEST_FACTOR),
                _ => {}
            }
        }
        self.round += 1;
        let (rounds, unknowns) = match self.stage {
            Stage::One => (ROUNDS.0, K2),
            Stage::Free => (ROUNDS.2, UNKNOWNS),
            _ => (ROUNDS.1, UNKNOWNS),
        };
        if self.round < rounds {
            self.triangle.restart();
            return false;
        }
        let freedom = (2 * self.points.len()).saturating_sub(unknowns).max(1) as f32;
        let misfit = libm::sqrtf(self.triangle.rest() / freedom);
        let part = |best: &Solution| if best.elements[K2] == 0.0 { BETTER } else { 1.0 };
        let better = self.best.as_ref().is_none_or(|best| misfit < part(best) * best.misfit && is_plausible(&self.elements));
        // In place: a factor is long to move.
        let best = self.best.get_or_insert_default();
        if better {
            (best.elements, best.misfit) = (self.elements, misfit);
            best.triangle.clone_from(&self.triangle);
        }
        self.triangle.restart();
        // What is no number ends it, too.
        match self.stage {
            Stage::One if best.misfit > MISFIT => {
                self.one = best.elements;
                self.start_beside(Stage::Above, SECOND.0)
            }
            Stage::Above if best.misfit > MISFIT => {
                self.stage = Stage::StartTwo;
                false
            }
            Stage::Two if best.misfit > MISFIT && best.elements[K2] == 0.0 => self.start_beside(Stage::Free, -SECOND.0),
            Stage::Two if best.misfit > MISFIT => {
                (self.elements, self.round, self.stage) = (best.elements, 0, Stage::Free);
                false
            }
            _ => true,
        }
    }

    /// Begins with a second resonance so far from the first. It is not over.
    fn start_beside(&mut self, stage: Stage, apart: f32) -> bool {
        (self.elements, self.round, self.stage) = (self.one, 0, stage);
        (self.elements[K2], self.elements[D2]) = (SECOND.1 * self.elements[K], self.elements[D]);
        self.elements[X2] = self.elements[XS] + apart;
        false
    }
}

/// Whether a passive circuit can be so.
pub(crate) fn is_plausible(e: &Elements) -> bool {
    e[C] > 0.0 && e[K] > 0.0 && e[K2] >= 0.0 && e[XS].abs() < 0.25 && e[X2].abs() < 0.5 && e[D] > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const TONES: [f32; MAX_POINTS] = [-0.0413, 0.0413, -0.0692, 0.113, -0.1126, 0.1544, -0.171, 0.2124];

    fn solve(nominal_loss: f32, elements: &Elements) -> Solution {
        let mut fit = Fit::new(nominal_loss, 40e3);
        for x in TONES {
            fit.add(Point { x, y: admittance(elements, x).0, deviation: 4e-4 });
        }
        assert!((0..1000).any(|_| fit.advance()), "it ends");
        fit.solution().expect("a solution").clone()
    }

    #[test]
    fn finds_one_resonance_wherever_it_is() {
        for (xs, q) in [(-0.02, 20.0), (0.0, 65.0), (0.019, 1600.0)] {
            let exact: Elements = [1.04, 0.01, 0.015, 0.067, xs, 1.0 / q, 0.01, 0.0, 0.0, 0.0];
            let found = solve(2.0 / q, &exact);
            // Measured: 2e-6 of c, 4e-6 of the resonance, 1.3e-5 rad: rounding, and what is known beforehand.
            assert!((found.elements[C] - exact[C]).abs() < 2e-5, "{xs}: {:?}", found.elements);
            assert!((found.elements[XS] - xs).abs() < 1e-5, "{xs}: {:?}", found.elements);
            assert!((found.elements[THETA] - exact[THETA]).abs() < 1e-4, "{xs}: {:?}", found.elements);
            assert!(found.misfit < 0.5 && found.elements[K2] == 0.0, "{xs}: {}", found.misfit);
        }
    }

    #[test]
    fn finds_two_where_one_does_not_explain_it() {
        for (x2, k2, q, q2) in
            [(0.07, 0.02, 20.0, 20.0), (0.08, 0.007, 65.0, 300.0), (0.065, 0.02, 500.0, 100.0), (-0.07, 0.02, 65.0, 20.0)]
        {
            let exact: Elements = [0.97, 0.01, 0.015, 0.067, -0.01, 1.0 / q, -0.01, k2, x2, 1.0 / q2];
            let found = solve(0.6 / q, &exact);
            assert!(
                (found.elements[X2] - x2).abs() < 2e-4 && (found.elements[K2] / k2 - 1.0).abs() < 0.02,
                "{:?}",
                found.elements
            );
            // Measured: a misfit of 1.6, by losses that differ by five, for which there are few iterations.
            assert!((found.elements[C] - exact[C]).abs() < 1e-3 && found.misfit < 2.0, "{:?}", found.elements);
        }
    }
}
