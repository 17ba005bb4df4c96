//! Fit of the [model](super::model) to admittances at several frequencies, by Gauss-Newton
//! iteration. Each block processes one admittance, then the priors, then the solution. With two
//! resonances the rows are longer, and each block processes one component of an admittance.
//!
//! A linear fit without losses (Levy 1959) starts the iteration, so that no initial value of the
//! resonance is needed. With `Z = Im Y / u`, `v = u^2 - 1`,
//!
//! ```text
//! one resonance:  Z v   = w Z - p + c v,              us^2 - 1 = w,  k = p - c w
//! two:            Z v^2 = -a Z v - b Z + c v^2 + e v + p,   us^2 - 1 and u2^2 - 1 the roots of v^2 + a v + b
//! ```
//!
//! If one resonance does not explain the measurement, two are tried in this order:
//!
//! 1. a second resonance above the first, with the same loss;
//! 2. a linear fit of two resonances, with the same loss;
//! 3. a second resonance with its own loss, from the best of these, or below the first.
//!
//! Two resonances are accepted only if they reduce the residual to a third. They always reduce it
//! somewhat, with nine or ten unknowns for sixteen numbers.

use heapless::Vec;

use crate::find::clamped::model::{C, D, D2, Elements, G, H, K, K2, THETA, UNKNOWNS, X2, XS, admittance};
use crate::find::givens::RealTriangle;
use crate::seam::compare::within;
use crate::seam::phasor::Phasor;

/// Maximum number of admittances.
pub(crate) const MAX_POINTS: usize = 8;
/// Iterations with one resonance. Below an error of 1e-2, each iteration nearly squares it.
const ROUNDS_ONE: u32 = 5;
/// Iterations with two resonances.
const ROUNDS_TWO: u32 = 8;
/// Iterations with two resonances of which one has its own loss; limited by time.
const ROUNDS_FREE: u32 = 5;
/// Maximum rms residual of one resonance, in standard deviations.
const MAX_MISFIT_SIGMAS: f32 = 4.0;
/// Maximum residual of two resonances, relative to that of one.
const MAX_MISFIT_RATIO: f32 = 1.0 / 3.0;
/// Initial distance of a second resonance above or below the first, relative to the nominal
/// frequency.
const SECOND_DISTANCE: f32 = 0.06;
/// Initial strength of a second resonance, relative to the first.
const SECOND_STRENGTH_REL: f32 = 0.15;
/// Priors: index of the element, and standard deviation around zero. The loss is relative to the
/// nominal loss, and the loss of a second resonance relative to the first. `theta` is a time skew
/// between the sense channels, s.
const PRIORS: [(usize, f32); 5] = [(XS, 0.1), (D, 4.0), (THETA, 150e-9), (X2, 0.2), (D2, 1.0)];
/// Standard deviation of the difference of both losses, relative to the first, when they are
/// assumed equal.
const SAME_LOSS_DEVIATION_REL: f32 = 0.01;
/// Exponent with which the loss of the clamped branch rises with frequency: between a dielectric
/// (1) and images (2).
const LOSS_EXPONENT: f32 = 1.5;
/// Standard deviation of that slope, relative to the clamped susceptance.
const LOSS_DEVIATION: f32 = 0.02;
/// Maximum change of a resonance per iteration.
const MAX_RESONANCE_STEP: f32 = 0.01;
/// Maximum factor per iteration for a loss, a strength or the clamped capacitance.
const MAX_FACTOR: f32 = 3.0;
/// Maximum rotation by the sensing chain, rad.
const MAX_THETA_RAD: f32 = 0.3;

/// Admittance relative to the nominal clamped susceptance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// Offset from the nominal frequency, relative to it.
    pub(crate) x: f32,
    /// Admittance.
    pub(crate) y: Phasor,
    /// Standard deviation of each component.
    pub(crate) deviation: f32,
}

/// Component of an admittance: real or imaginary part.
type Part = fn(Phasor) -> f32;
const PARTS: [Part; 2] = [|y| y.re, |y| y.im];

/// Model that is being fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    StartOne,
    One,
    /// Second resonance above the first, with the same loss.
    Above,
    /// Second resonance with its own loss.
    Free,
    StartTwo,
    Two,
}

/// Fitted elements, and the quality of the fit.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solution {
    /// Fitted elements.
    pub(crate) elements: Elements,
    /// Triangular factor of the fit.
    pub(crate) triangle: RealTriangle<UNKNOWNS>,
    /// Rms residual per degree of freedom, in standard deviations; one if the model holds.
    pub(crate) misfit: f32,
}

impl Solution {
    /// Returns the standard deviation of a sum of elements; larger if the model does not hold.
    pub(crate) fn deviation(&self, of: &[f32; UNKNOWNS]) -> f32 {
        self.triangle.deviation(of) * self.misfit.max(1.0)
    }
}

/// Fit in progress.
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
    /// Best fit of one resonance.
    one: Elements,
}

impl Fit {
    /// Creates a fit without points, from the nominal `loss` `1 / Q` and the nominal frequency, Hz.
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

    /// Adds a point; ignores it if there is no room.
    pub(crate) fn add(&mut self, point: Point) {
        let _ = self.points.push(point);
    }

    /// Returns the best solution; final once [`advance`](Self::advance) has returned `true`.
    pub(crate) fn solution(&self) -> Option<&Solution> {
        self.best.as_ref()
    }

    /// Does the work of one block. Returns `true` if the fit has ended.
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
                    self.fold_priors();
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

    /// Folds components of an admittance into the factor.
    fn fold(&mut self, point: Point, parts: &[Part]) {
        let (y, by) = admittance(&self.elements, point.x);
        let weight = 1.0 / point.deviation;
        let (left, unknown) = (point.y - y, if self.stage == Stage::One { K2 } else { UNKNOWNS });
        for part in parts {
            let row = core::array::from_fn(|n| if n < unknown { part(by[n]) * weight } else { 0.0 });
            self.triangle.fold_among(unknown, row, part(left) * weight);
        }
    }

    /// Starts the iteration from the result of the linear fit.
    fn start(&mut self) {
        let resonance = |w: f32| fpu::sqrtf((1.0 + w).clamp(0.6, 1.6)) - 1.0;
        let mut e = Elements::default();
        e[D] = self.loss;
        if self.stage == Stage::StartOne {
            let [w, p, c, ..] = self.triangle.solve();
            (e[C], e[K], e[XS]) = (c, p - c * w, resonance(w));
            self.stage = Stage::One;
        } else {
            let [a, b, c, slope, p, ..] = self.triangle.solve();
            let apart = fpu::sqrtf((a * a - 4.0 * b).max(1e-4));
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

    fn fold_priors(&mut self) {
        for (n, deviation) in PRIORS {
            let (expected, deviation) = match n {
                D => (self.loss, deviation * self.loss),
                THETA => (0.0, deviation * self.omega),
                X2 | D2 if self.stage == Stage::One => continue,
                D2 => (
                    self.elements[D],
                    if self.stage == Stage::Free { deviation } else { SAME_LOSS_DEVIATION_REL } * self.elements[D],
                ),
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
        (rises[H], rises[G]) = (1.0 / LOSS_DEVIATION, -LOSS_EXPONENT / LOSS_DEVIATION);
        self.triangle.fold(rises, (LOSS_EXPONENT * self.elements[G] - self.elements[H]) / LOSS_DEVIATION);
    }

    fn finish_round(&mut self) -> bool {
        for (n, (element, step)) in self.elements.iter_mut().zip(self.triangle.solve()).enumerate() {
            let before = *element;
            *element += step;
            match n {
                XS | X2 => *element = within(*element, before - MAX_RESONANCE_STEP, before + MAX_RESONANCE_STEP),
                THETA => *element = within(*element, -MAX_THETA_RAD, MAX_THETA_RAD),
                D | D2 | C | K if before > 0.0 => *element = within(*element, before / MAX_FACTOR, before * MAX_FACTOR),
                _ => {}
            }
        }
        self.round += 1;
        let (rounds, unknowns) = match self.stage {
            Stage::One => (ROUNDS_ONE, K2),
            Stage::Free => (ROUNDS_FREE, UNKNOWNS),
            _ => (ROUNDS_TWO, UNKNOWNS),
        };
        if self.round < rounds {
            self.triangle.restart();
            return false;
        }
        let freedom = (2 * self.points.len()).saturating_sub(unknowns).max(1) as f32;
        let misfit = fpu::sqrtf(self.triangle.rest() / freedom);
        let part = |best: &Solution| if best.elements[K2] == 0.0 { MAX_MISFIT_RATIO } else { 1.0 };
        let better = self.best.as_ref().is_none_or(|best| misfit < part(best) * best.misfit && is_plausible(&self.elements));
        // In place, since moving a factor takes long.
        let best = self.best.get_or_insert_default();
        if better {
            (best.elements, best.misfit) = (self.elements, misfit);
            best.triangle.clone_from(&self.triangle);
        }
        self.triangle.restart();
        // A NaN misfit ends the fit, too.
        match self.stage {
            Stage::One if best.misfit > MAX_MISFIT_SIGMAS => {
                self.one = best.elements;
                self.start_second(Stage::Above, SECOND_DISTANCE)
            }
            Stage::Above if best.misfit > MAX_MISFIT_SIGMAS => {
                self.stage = Stage::StartTwo;
                false
            }
            Stage::Two if best.misfit > MAX_MISFIT_SIGMAS && best.elements[K2] == 0.0 => {
                self.start_second(Stage::Free, -SECOND_DISTANCE)
            }
            Stage::Two if best.misfit > MAX_MISFIT_SIGMAS => {
                (self.elements, self.round, self.stage) = (best.elements, 0, Stage::Free);
                false
            }
            _ => true,
        }
    }

    /// Continues with a second resonance at the distance `apart` from the first. Returns `false`:
    /// the fit has not ended.
    fn start_second(&mut self, stage: Stage, apart: f32) -> bool {
        (self.elements, self.round, self.stage) = (self.one, 0, stage);
        (self.elements[K2], self.elements[D2]) = (SECOND_STRENGTH_REL * self.elements[K], self.elements[D]);
        self.elements[X2] = self.elements[XS] + apart;
        false
    }
}

/// Returns `true` if the elements can be those of a passive circuit.
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
        assert!((0..1000).any(|_| fit.advance()), "the fit does not end");
        fit.solution().expect("a solution").clone()
    }

    #[test]
    fn finds_one_resonance_at_any_frequency() {
        for (xs, q) in [(-0.02, 20.0), (0.0, 65.0), (0.019, 1600.0)] {
            let exact: Elements = [1.04, 0.01, 0.015, 0.067, xs, 1.0 / q, 0.01, 0.0, 0.0, 0.0];
            let found = solve(2.0 / q, &exact);
            // Measured: 2e-6 of c, 4e-6 of the resonance, 1.3e-5 rad, from rounding and priors.
            assert!((found.elements[C] - exact[C]).abs() < 2e-5, "{xs}: {:?}", found.elements);
            assert!((found.elements[XS] - xs).abs() < 1e-5, "{xs}: {:?}", found.elements);
            assert!((found.elements[THETA] - exact[THETA]).abs() < 1e-4, "{xs}: {:?}", found.elements);
            assert!(found.misfit < 0.5 && found.elements[K2] == 0.0, "{xs}: {}", found.misfit);
        }
    }

    #[test]
    fn finds_two_if_one_does_not_explain_the_data() {
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
            // Measured: a misfit of 1.6. Two modes whose losses differ by a factor of five converge
            // slowly.
            assert!((found.elements[C] - exact[C]).abs() < 1e-3 && found.misfit < 2.0, "{:?}", found.elements);
        }
    }
}
