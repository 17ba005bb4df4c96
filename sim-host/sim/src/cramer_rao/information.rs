//! Fisher information (Fisher 1922) of several parameters, and the minimum standard deviation of
//! one of them.
//!
//! Samples `x(n) + noise` with independent noise of standard deviation s add
//! `sum (dx/da)(dx/db) / s^2`; a prior of standard deviation p adds `1 / p^2` (van Trees 1968,
//! section 2.4). No unbiased estimate has a smaller covariance than the inverse (Rao 1945, Cramer
//! 1946).

use super::response::PARAMETERS;

/// Prior knowledge of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Knowledge {
    /// The parameter is unknown.
    Unknown,
    /// The parameter has a prior of this standard deviation, in its unit.
    Within(f64),
    /// The parameter is known exactly.
    Known,
}

impl Knowledge {
    /// Returns a uniform prior of this half width, in the parameter's unit, as the Gaussian of the
    /// same variance.
    pub fn either_side(half_width: f64) -> Self {
        Knowledge::Within(half_width / 3f64.sqrt())
    }
}

/// Minimum pivot of a matrix with unit diagonal that is significant against rounding.
const MIN_PIVOT: f64 = 1e-12;

/// Information about all parameters.
#[derive(Clone, Debug, Default)]
pub(super) struct Information([[f64; PARAMETERS]; PARAMETERS]);

impl Information {
    /// Adds one sample with this noise variance.
    pub(super) fn add(&mut self, by: &[f64; PARAMETERS], variance: f64) {
        for (row, a) in self.0.iter_mut().zip(by) {
            for (sum, b) in row.iter_mut().zip(by) {
                *sum += a * b / variance;
            }
        }
    }

    /// Returns one column of the matrix: the information that parameter `n` shares with each
    /// parameter.
    pub(super) fn column(&self, n: usize) -> [f64; PARAMETERS] {
        self.0[n]
    }

    /// Adds the priors; rows and columns of known parameters become zero.
    pub(super) fn with(mut self, known: &[Knowledge; PARAMETERS]) -> Self {
        for (n, knowledge) in known.iter().enumerate() {
            match knowledge {
                Knowledge::Unknown => {}
                Knowledge::Within(deviation) => self.0[n][n] += deviation.powi(-2),
                Knowledge::Known => {
                    self.0[n] = [0.0; PARAMETERS];
                    self.0.iter_mut().for_each(|row| row[n] = 0.0);
                }
            }
        }
        self
    }

    /// Multiplies a vector by the inverse, with the Cholesky factors; known parameters remain zero.
    /// `None` if a parameter is not determined.
    pub(super) fn solve(&self, vector: &[f64; PARAMETERS], known: &[Knowledge; PARAMETERS]) -> Option<[f64; PARAMETERS]> {
        let is_known = |n: usize| known[n] == Knowledge::Known;
        // Scaled to a unit diagonal, because the units differ by orders of magnitude.
        let scale: [f64; PARAMETERS] = std::array::from_fn(|n| if is_known(n) { 0.0 } else { self.0[n][n].sqrt().recip() });
        if !scale.iter().all(|x| x.is_finite()) {
            return None;
        }
        let mut lower = [[0.0; PARAMETERS]; PARAMETERS];
        for row in 0..PARAMETERS {
            for column in 0..=row {
                let scaled = if row == column { 1.0 } else { self.0[row][column] * scale[row] * scale[column] };
                let rest = scaled - (0..column).map(|n| lower[row][n] * lower[column][n]).sum::<f64>();
                lower[row][column] = if row > column {
                    rest / lower[column][column]
                } else if rest > MIN_PIVOT {
                    rest.sqrt()
                } else {
                    return None;
                };
            }
        }
        let mut x = [0.0; PARAMETERS];
        for row in 0..PARAMETERS {
            x[row] = (vector[row] * scale[row] - (0..row).map(|n| lower[row][n] * x[n]).sum::<f64>()) / lower[row][row];
        }
        for row in (0..PARAMETERS).rev() {
            x[row] = (x[row] - (row + 1..PARAMETERS).map(|n| lower[n][row] * x[n]).sum::<f64>()) / lower[row][row];
        }
        Some(std::array::from_fn(|n| x[n] * scale[n]))
    }

    /// Returns the minimum standard deviation of a weighted sum of the parameters; infinite if it
    /// is not determined.
    pub(super) fn deviation(&self, weight: &[f64; PARAMETERS], known: &[Knowledge; PARAMETERS]) -> f64 {
        let Some(x) = self.solve(weight, known) else { return f64::INFINITY };
        x.iter().zip(weight).map(|(x, weight)| x * weight).sum::<f64>().sqrt()
    }
}
