//! The elements of the [model] from admittances at some frequencies: Gauss and Newton's iteration, one equation a block.
//!
//! Started by a linear fit without losses, `Z v = w Z - (c w + k) + c v` with `Z = Im Y / u`, `v = u^2 - 1`, `w = us^2 - 1` (Levy 1959), so that nobody
//! needs to know where the resonance is. What one resonance cannot explain is tried with two.

use heapless::Vec;

use crate::clamped::model::{C, D, Elements, H, K, K2, THETA, UNKNOWNS, X2, XS, admittance};
use crate::clamped::triangle::Triangle;
use crate::phasor::Phasor;

/// The most admittances there can be.
pub const MAX_POINTS: usize = 8;
/// Iterations with one resonance, and with two. They square the error from 1e-2 on, or nearly so.
const ROUNDS: (u32, u32) = (5, 10);
/// Beyond this rms residual, in standard deviations, one resonance does not explain what was measured.
const MISFIT: f32 = 4.0;
/// Where a second resonance is looked for, relative to the first: above, and as a companion by a crack.
const SECOND: [f32; 2] = [0.06, -0.018];
/// Strength that it is thought to have at first, relative to the first.
const SECOND_STRENGTH: f32 = 0.15;
/// What is known beforehand, as standard deviations: loss of the clamped branch by its slope, resonance, loss relative to what was told,
/// what sensing turns (rad; 400 ns at 40 kHz), where the second resonance is relative to where it is looked for.
const KNOWN: [(usize, f32); 5] = [(H, 0.05), (XS, 0.1), (D, 4.0), (THETA, 0.1), (X2, 0.03)];
/// The most that a resonance may move in one iteration.
const LONGEST_STEP: f32 = 0.01;

/// An admittance, relative to the nominal clamped susceptance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Offset from the nominal frequency, relative to it.
    pub x: f32,
    /// The admittance.
    pub y: Phasor,
    /// Its standard deviation, of either part.
    pub deviation: f32,
}

/// What is fitted at present.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Start,
    One,
    /// With a second resonance, looked for there.
    Two(usize),
}

/// Elements that explain the points, and how well.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The elements.
    pub elements: Elements,
    /// Their triangular factor.
    pub triangle: Triangle<UNKNOWNS>,
    /// Root of what is left in the mean of the degrees of freedom, in standard deviations: one, if the model holds.
    pub misfit: f32,
}

impl Solution {
    /// Standard deviation of a sum of elements, larger where the model does not hold.
    pub fn deviation(&self, of: &[f32; UNKNOWNS]) -> f32 {
        self.triangle.deviation(of) * self.misfit.max(1.0)
    }
}

/// The fit, in progress.
#[derive(Clone, Debug)]
pub struct Fit {
    loss: f32,
    points: Vec<Point, MAX_POINTS>,
    stage: Stage,
    round: u32,
    row: usize,
    elements: Elements,
    triangle: Triangle<UNKNOWNS>,
    best: Option<Solution>,
}

impl Fit {
    /// Without a point. `loss`: the nominal one, `1 / Q`.
    pub fn new(loss: f32) -> Self {
        Fit {
            loss,
            points: Vec::new(),
            stage: Stage::Start,
            round: 0,
            row: 0,
            elements: Elements::default(),
            triangle: Triangle::new(),
            best: None,
        }
    }

    /// Adds a point; no more than there is room for.
    pub fn add(&mut self, point: Point) {
        let _ = self.points.push(point);
    }

    /// Folds one equation. Returns the solution when it is found.
    pub fn advance(&mut self) -> Option<Solution> {
        let rows = match self.stage {
            Stage::Start => self.points.len(),
            _ => 2 * self.points.len(),
        };
        if let Some(point) = self.points.get(if self.stage == Stage::Start { self.row } else { self.row / 2 }) {
            match self.stage {
                Stage::Start => self.fold_linear(*point),
                _ => self.fold(*point, self.row % 2 == 1),
            }
        }
        self.row += 1;
        if self.row < rows {
            return None;
        }
        self.row = 0;
        if self.stage == Stage::Start {
            self.begin(Stage::One);
            return None;
        }
        self.finish_round()
    }

    fn fold_linear(&mut self, point: Point) {
        let v = point.x * (2.0 + point.x);
        let z = point.y.im / (1.0 + point.x);
        let weight = 1.0 / (v * point.deviation);
        let mut row = [0.0; UNKNOWNS];
        (row[0], row[1], row[2]) = (z * weight, -weight, v * weight);
        self.triangle.fold(row, z * v * weight);
    }

    fn fold(&mut self, point: Point, imaginary: bool) {
        let (y, by) = admittance(&self.elements, point.x);
        let part = |y: Phasor| if imaginary { y.im } else { y.re } / point.deviation;
        let unknown = if let Stage::Two(_) = self.stage { UNKNOWNS } else { K2 };
        self.triangle.fold(core::array::from_fn(|n| if n < unknown { part(by[n]) } else { 0.0 }), part(point.y - y));
    }

    /// Begins a stage where the last has ended.
    fn begin(&mut self, stage: Stage) {
        match (stage, &self.best) {
            (Stage::Two(n), Some(best)) => {
                self.elements = best.elements;
                self.elements[K2] = SECOND_STRENGTH * self.elements[K];
                self.elements[X2] = self.elements[XS] + SECOND[n];
            }
            _ => {
                let [w, p, c, ..] = self.triangle.solve();
                let xs = libm::sqrtf((1.0 + w).clamp(0.7, 1.4)) - 1.0;
                self.elements = Elements::default();
                (self.elements[C], self.elements[K], self.elements[XS]) = (c, p - c * w, xs);
                self.elements[D] = self.loss;
            }
        }
        (self.stage, self.round) = (stage, 0);
        self.triangle = Triangle::new();
    }

    fn finish_round(&mut self) -> Option<Solution> {
        for (n, deviation) in KNOWN {
            let (expected, deviation) = match (n, self.stage) {
                (D, _) => (self.loss, deviation * self.loss),
                (X2, Stage::Two(second)) => (self.elements[XS] + SECOND[second], deviation),
                (X2, _) => continue,
                _ => (0.0, deviation),
            };
            let mut row = [0.0; UNKNOWNS];
            row[n] = 1.0 / deviation;
            self.triangle.fold(row, (expected - self.elements[n]) / deviation);
        }
        let (step, d) = (self.triangle.solve(), self.elements[D]);
        for n in 0..UNKNOWNS {
            self.elements[n] += if n == XS || n == X2 { step[n].clamp(-LONGEST_STEP, LONGEST_STEP) } else { step[n] };
        }
        self.elements[D] = self.elements[D].clamp(d / 3.0, d * 3.0);
        self.round += 1;
        let (rounds, unknowns) = if self.stage == Stage::One { (ROUNDS.0, K2) } else { (ROUNDS.1, UNKNOWNS) };
        if self.round < rounds {
            self.triangle = Triangle::new();
            return None;
        }
        let freedom = (2 * self.points.len()).saturating_sub(unknowns).max(1) as f32;
        let misfit = libm::sqrtf(self.triangle.rest() / freedom);
        if self.best.as_ref().is_none_or(|best| misfit < best.misfit) {
            self.best = Some(Solution { elements: self.elements, triangle: self.triangle.clone(), misfit });
        }
        // What is no number is not better, and ends it.
        let next = match self.stage {
            Stage::Two(n) => n + 1,
            _ => 0,
        };
        if self.best.as_ref().is_some_and(|best| best.misfit > MISFIT) && next < SECOND.len() {
            self.begin(Stage::Two(next));
            return None;
        }
        self.best.take()
    }
}
