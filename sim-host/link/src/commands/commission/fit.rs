//! Least-squares fit of circuits with one, two or three resonances to measured admittance.
//!
//! ```text
//! Y(f) = Y0 + Y1 (f - f0) + sum over resonances of  G / (1 + j Q (f / fs - fs / f))
//! ```
//!
//! Each resonance has its own fs, Q and G, all real. Y0 and Y1 are complex: they contain the
//! clamped capacitance, its losses, the images of the DAC in its current, and distant modes. The
//! standard deviations of the points are known. A circle has only 9 to 17 points, too few to
//! estimate a noise model as `import admittance` does with hundreds. Branches and least squares are
//! the same.

use std::f64::consts::TAU;

use import::admittance::circuit::{BRANCH_PARAMETERS, Branch, branch};
use import::least_squares::{Linear, minimise};
use realfft::num_complex::Complex64;

/// Number of parameters of the background.
const BACKGROUND_PARAMETERS: usize = 4;
/// Lower bound of the quality factor.
const MIN_Q: f64 = 0.5;
/// Upper bound of the quality factor.
const MAX_Q: f64 = 1e6;

/// Admittance at a frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Frequency, Hz.
    pub hz: f64,
    /// Admittance, S.
    pub siemens: Complex64,
    /// Standard deviation of real and imaginary part, S.
    pub deviation: f64,
}

/// Fitted circuit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Background: reference frequency, Hz, admittance at this frequency, S, and slope of the
    /// admittance, S/Hz.
    pub background: (f64, Complex64, Complex64),
    /// Resonances, in the order of their starting values.
    pub resonances: Vec<Branch>,
    /// Standard deviation of each series resonance, Hz.
    pub deviations_hz: Vec<f64>,
    /// Sum of the squared distances, in standard deviations of the points.
    pub squares: f64,
    /// Degrees of freedom: measured numbers minus fitted parameters.
    pub free: usize,
}

impl Fit {
    /// Returns the mean squared distance, in standard deviations of the points; about 1 if only
    /// noise remains.
    pub fn mean_square(&self) -> f64 {
        self.squares / self.free as f64
    }

    /// Returns the capacitance of the background, F.
    pub fn c0_f(&self) -> f64 {
        let (at_hz, y0, _) = self.background;
        y0.im / (TAU * at_hz)
    }

    /// Returns the rms distance of points from the circuit, S.
    pub fn distance(&self, points: &[Point]) -> f64 {
        let admittance = |hz: f64| {
            let motional: Complex64 = self.resonances.iter().map(|it| it.admittance(hz)).sum();
            let (at_hz, y0, slope) = self.background;
            motional + y0 + slope * (hz - at_hz)
        };
        let squares: f64 = points.iter().map(|point| (point.siemens - admittance(point.hz)).norm_sqr()).sum();
        (squares / points.len() as f64).sqrt()
    }

    /// Returns the index of the strongest resonance, with the largest motional capacitance.
    pub fn strongest(&self) -> usize {
        let places = 0..self.resonances.len();
        places.max_by(|&a, &b| self.resonances[a].cm_f().total_cmp(&self.resonances[b].cm_f())).unwrap_or(0)
    }
}

/// Fits a circuit to points, starting from these resonances. Returns `None` if there are too few
/// points, or if they do not determine the circuit.
pub fn fit(points: &[Point], from: &[Branch]) -> Option<Fit> {
    let first = from.first()?;
    let (hz, width_hz) = (first.hz, first.hz / first.q);
    let free = (2 * points.len()).checked_sub(BACKGROUND_PARAMETERS + BRANCH_PARAMETERS * from.len()).filter(|&free| free > 0)?;
    // The background starts as the mean residual of the resonances.
    let rest = |point: &Point| point.siemens - from.iter().map(|it| it.admittance(point.hz)).sum::<Complex64>();
    let y0 = points.iter().map(rest).sum::<Complex64>() / points.len() as f64;
    let start: Vec<f64> = [y0.re, y0.im, 0.0, 0.0].into_iter().chain(from.iter().flat_map(Branch::parameters)).collect();
    let found = minimise(&start, |parameters| linear(points, parameters, (hz, width_hz)))?;
    // A misfit beyond the noise increases the standard deviations.
    let worse = (found.cost / free as f64).max(1.0).sqrt();
    let covariance = found.covariance()?;
    let resonances: Vec<Branch> =
        found.parameters[BACKGROUND_PARAMETERS..].chunks_exact(BRANCH_PARAMETERS).map(Branch::from_parameters).collect();
    let deviation_ln = |n: usize| {
        worse * covariance[(BACKGROUND_PARAMETERS + BRANCH_PARAMETERS * n, BACKGROUND_PARAMETERS + BRANCH_PARAMETERS * n)].sqrt()
    };
    let deviations_hz = resonances.iter().enumerate().map(|(n, it)| it.hz * deviation_ln(n)).collect();
    let complex = |at: usize| Complex64::new(found.parameters[at], found.parameters[at + 1]);
    Some(Fit { background: (hz, complex(0), complex(2) / width_hz), resonances, deviations_hz, squares: found.cost, free })
}

/// Computes the residuals in standard deviations, with derivatives: first the real parts of all
/// points, then the imaginary parts. Returns none beyond the bounds of Q.
fn linear(points: &[Point], parameters: &[f64], (hz, width_hz): (f64, f64)) -> Option<Linear> {
    let (background, branches) = parameters.split_at(BACKGROUND_PARAMETERS);
    if !branches.chunks_exact(BRANCH_PARAMETERS).all(|own| (MIN_Q.ln()..MAX_Q.ln()).contains(&own[1])) {
        return None;
    }
    let mut residuals = vec![0.0; 2 * points.len()];
    let mut columns = vec![residuals.clone(); parameters.len()];
    for (at, point) in points.iter().enumerate() {
        let x = (point.hz - hz) / width_hz;
        let mut slopes = vec![Complex64::ONE, Complex64::I, x.into(), x * Complex64::I];
        let mut y: Complex64 = slopes.iter().zip(background).map(|(by, value)| by * value).sum();
        for own in branches.chunks_exact(BRANCH_PARAMETERS) {
            let (siemens, by) = branch([own[0], own[1], own[2]], point.hz);
            y += siemens;
            slopes.extend(by);
        }
        let put = |row: &mut [f64], value: Complex64| {
            (row[at], row[points.len() + at]) = (value.re / point.deviation, value.im / point.deviation);
        };
        put(&mut residuals, y - point.siemens);
        columns.iter_mut().zip(slopes).for_each(|(column, slope)| put(column, slope));
    }
    residuals.iter().all(|residual| residual.is_finite()).then_some(Linear { residuals, columns })
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAIN: Branch = Branch { hz: 40e3, q: 50.0, siemens: 0.3 };

    /// Returns points up to two bandwidths from the main resonance, with 300 nF in parallel and a
    /// deviation that alternates from point to point.
    fn points(further: &[Branch], deviation: f64) -> Vec<Point> {
        (0..21)
            .map(|n| {
                let hz = 40e3 + 800.0 * 0.2 * (f64::from(n) - 10.0);
                let y: Complex64 = [MAIN].iter().chain(further).map(|it| it.admittance(hz)).sum();
                let noise = deviation * if n % 2 == 0 { Complex64::ONE } else { -Complex64::I };
                Point { hz, siemens: y + Complex64::new(0.0, TAU * hz * 300e-9) + noise, deviation: deviation.max(1e-6) }
            })
            .collect()
    }

    #[test]
    fn one_resonance_is_fitted_from_a_wrong_start() {
        let start = Branch { hz: 40.1e3, q: 70.0, siemens: 0.25 };
        let fit = fit(&points(&[], 0.0), &[start]).unwrap();
        let found = fit.resonances[0];
        assert!((found.hz - MAIN.hz).abs() < 1e-3 && (found.q - 50.0).abs() < 1e-3, "{fit:?}");
        assert!((fit.c0_f() / 300e-9 - 1.0).abs() < 1e-6 && fit.mean_square() < 1e-3, "{fit:?}");
    }

    #[test]
    fn two_resonances_within_a_bandwidth_are_distinguished() {
        let further = Branch { hz: 40.5e3, q: 80.0, siemens: 0.06 };
        let points = points(&[further], 1e-4);
        let one = fit(&points, &[MAIN]).unwrap();
        assert!(one.mean_square() > 30.0 && (one.resonances[0].hz - MAIN.hz).abs() > 20.0, "{one:?}");
        let two = fit(&points, &[one.resonances[0], Branch { hz: 40.8e3, q: 50.0, siemens: 0.03 }]).unwrap();
        assert!(two.mean_square() < 2.0, "{two:?}");
        assert!((two.resonances[0].hz - MAIN.hz).abs() < 5.0 * two.deviations_hz[0] && two.deviations_hz[0] < 4.0, "{two:?}");
        assert!((two.resonances[1].hz - 40.5e3).abs() < 5.0 * two.deviations_hz[1], "{two:?}");
    }

    #[test]
    fn too_few_points_give_no_fit() {
        assert_eq!(fit(&points(&[], 0.0)[..2], &[MAIN]), None);
        assert_eq!(fit(&[], &[MAIN]), None);
    }
}
