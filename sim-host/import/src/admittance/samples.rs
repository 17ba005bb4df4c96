//! Random draws of a fitted circuit for a scene, with the covariance of the fit.
//!
//! Resonance, Q, Lm and C0 are drawn by their covariance, and `Cm = 1 / (w^2 Lm)` and
//! `Rm = w Lm / Q` follow. Drawn themselves, Lm and Cm would have to cancel to the last digits.

use std::fmt::Write as _;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::result::{Admittance, Circuit};
use crate::synthetic::random::Random;

/// Number of draws.
const DRAWS: usize = 256;
/// Names of the drawn values, among those of a circuit.
const DRAWN: [&str; 4] = ["series_resonance_hz", "q", "lm_h", "c0_f"];
/// Number added to the diagonal of the correlations, so that rounding does not make them
/// indefinite.
const RIDGE: f64 = 1e-12;

impl Admittance {
    /// Returns draws of the stack's circuit as CSV, with the keys of a scene as columns; `None` if
    /// the fit has no finite deviations.
    pub fn samples(&self) -> Option<String> {
        let values = self.circuit.values();
        let places = DRAWN.map(|name| Circuit::NAMES.iter().position(|known| *known == name));
        let places: Vec<usize> = places.into_iter().flatten().collect();
        let correlation = DMatrix::from_fn(DRAWN.len(), DRAWN.len(), |i, j| {
            self.correlations[places[i]][places[j]] + if i == j { RIDGE } else { 0.0 }
        });
        let factor = Cholesky::new(correlation)?.l();
        let mut random = Random::new(1);
        let mut text = String::from("c0_f,cm_f,lm_h,rm_ohm\n");
        for _ in 0..DRAWS {
            let draw = &factor * DVector::from_fn(DRAWN.len(), |_, _| random.normal());
            let [hz, q, lm, c0] = std::array::from_fn(|at| values[places[at]].value + values[places[at]].sd * draw[at]);
            let omega = std::f64::consts::TAU * hz;
            let row = [c0, 1.0 / (omega * omega * lm), lm, omega * lm / q];
            if !row.iter().all(|value| value.is_finite() && *value > 0.0) {
                return None;
            }
            let _ = writeln!(text, "{:e},{:e},{:e},{:e}", row[0], row[1], row[2], row[3]);
        }
        Some(text)
    }
}
