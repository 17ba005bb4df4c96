//! Circuits of one, two or three resonances, fitted to measured admittance by least squares.
//!
//! ```text
//! Y(f) = Y0 + Y1 (f - f0) + sum over resonances of  G / (1 + j Q (f / fs - fs / f))
//! ```
//!
//! Each resonance has its own fs, Q and G, all real. Y0 and Y1 are complex: the clamped capacitance, its losses, the images of the DAC in its current, and
//! modes far away.
//!
//! Gauss-Newton with the damping of Levenberg and Marquardt (K. Madsen, H. B. Nielsen and
//! O. Tingleff, Methods for non-linear least squares problems, 2004), in units of the first resonance: frequencies in its bandwidths, admittances in
//! its conductance.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use realfft::num_complex::Complex64;

/// Parameters of the background, and of a resonance.
const BACKGROUND: usize = 4;
const EACH: usize = 3;
/// Steps of a fit at most, and the relative change of the sum of squares that ends it.
const STEPS: (usize, f64) = (120, 1e-9);
/// Damping: the first one, and by what it changes.
const DAMPING: (f64, f64) = (1e-3, 4.0);
/// Bounds of Q.
const QUALITIES: (f64, f64) = (0.5, 1e6);

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

/// A resonance of a circuit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonance {
    /// Series resonance, Hz.
    pub hz: f64,
    /// Quality factor.
    pub q: f64,
    /// Conductance at the series resonance, S.
    pub siemens: f64,
}

impl Resonance {
    /// Admittance at a frequency, S.
    pub fn admittance(&self, hz: f64) -> Complex64 {
        self.siemens / Complex64::new(1.0, self.q * (hz / self.hz - self.hz / hz))
    }

    /// Motional capacitance, F.
    pub fn cm_f(&self) -> f64 {
        self.siemens / (TAU * self.hz * self.q)
    }
}

/// A fitted circuit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Frequency that the background is of, Hz; its admittance there, S, and the slope of that, S/Hz.
    pub background: (f64, Complex64, Complex64),
    /// The resonances, in the order of their starting values.
    pub resonances: Vec<Resonance>,
    /// Standard deviation of each series resonance, Hz.
    pub deviations_hz: Vec<f64>,
    /// Sum of the squares of all distances, in deviations of the points.
    pub squares: f64,
    /// Numbers measured beyond those fitted.
    pub free: usize,
}

impl Fit {
    /// Mean square of the distances, in deviations of the points: one where nothing but noise is left.
    pub fn mean_square(&self) -> f64 {
        self.squares / self.free as f64
    }

    /// Capacitance of the background, F.
    pub fn c0_f(&self) -> f64 {
        let (at_hz, y0, _) = self.background;
        y0.im / (TAU * at_hz)
    }

    /// Rms distance of points from the circuit, S.
    pub fn distance(&self, points: &[Point]) -> f64 {
        let admittance = |hz: f64| {
            let motional: Complex64 = self.resonances.iter().map(|it| it.admittance(hz)).sum();
            let (at_hz, y0, slope) = self.background;
            motional + y0 + slope * (hz - at_hz)
        };
        let squares: f64 = points.iter().map(|point| (point.siemens - admittance(point.hz)).norm_sqr()).sum();
        (squares / points.len() as f64).sqrt()
    }

    /// The place of the strongest resonance, that of the largest motional capacitance.
    pub fn strongest(&self) -> usize {
        let places = 0..self.resonances.len();
        places.max_by(|&a, &b| self.resonances[a].cm_f().total_cmp(&self.resonances[b].cm_f())).unwrap_or(0)
    }
}

/// Units of the parameters: those of a resonance.
#[derive(Clone, Copy)]
struct Units {
    hz: f64,
    width_hz: f64,
    siemens: f64,
}

impl Units {
    fn resonance(&self, of: &[f64]) -> Resonance {
        Resonance { hz: self.hz + of[0] * self.width_hz, q: of[1].exp(), siemens: of[2] * self.siemens }
    }

    /// Admittance at a frequency, and its derivatives by all parameters, in units.
    fn row(&self, parameters: &[f64], hz: f64) -> (Complex64, Vec<Complex64>) {
        let x = (hz - self.hz) / self.width_hz;
        let mut by = vec![Complex64::ONE, Complex64::I, x.into(), x * Complex64::I];
        let mut y: Complex64 = by.iter().zip(parameters).map(|(by, of)| by * of).sum();
        for of in parameters[BACKGROUND..].chunks(EACH) {
            let it = self.resonance(of);
            let (turn, rise) = (it.q * (hz / it.hz - it.hz / hz), it.q * (hz / (it.hz * it.hz) + 1.0 / hz));
            let shape = Complex64::new(1.0, turn).inv();
            let slope = Complex64::new(0.0, of[2]) * shape * shape;
            y += of[2] * shape;
            by.extend([slope * rise * self.width_hz, -slope * turn, shape]);
        }
        (y, by)
    }

    /// Sum of squares of the distances, in deviations of the points.
    fn squares(&self, parameters: &[f64], points: &[Point]) -> f64 {
        let distance = |point: &Point| {
            let (y, _) = self.row(parameters, point.hz);
            (point.siemens / self.siemens - y).norm_sqr() / (point.deviation / self.siemens).powi(2)
        };
        points.iter().map(distance).sum()
    }

    /// Normal equations about these parameters.
    fn normal(&self, parameters: &[f64], points: &[Point]) -> (DMatrix<f64>, DVector<f64>) {
        let number = parameters.len();
        let (mut matrix, mut right) = (DMatrix::zeros(number, number), DVector::zeros(number));
        for point in points {
            let (y, by) = self.row(parameters, point.hz);
            let weight = (self.siemens / point.deviation).powi(2);
            let apart = point.siemens / self.siemens - y;
            for (row, a) in by.iter().enumerate() {
                right[row] += weight * (a.conj() * apart).re;
                for (column, b) in by.iter().enumerate() {
                    matrix[(row, column)] += weight * (a.conj() * b).re;
                }
            }
        }
        (matrix, right)
    }
}

/// Fits a circuit to points, from these resonances on. None where there are too few points, or they do not determine the circuit.
pub fn fit(points: &[Point], from: &[Resonance]) -> Option<Fit> {
    let first = from.first()?;
    let units = Units { hz: first.hz, width_hz: first.hz / first.q, siemens: first.siemens };
    let number = BACKGROUND + EACH * from.len();
    let free = (2 * points.len()).checked_sub(number).filter(|&free| free > 0)?;
    // The background is, to begin with, what the resonances leave.
    let left = |point: &Point| point.siemens - from.iter().map(|it| it.admittance(point.hz)).sum::<Complex64>();
    let y0 = points.iter().map(left).sum::<Complex64>() / (points.len() as f64 * units.siemens);
    let mut parameters = vec![y0.re, y0.im, 0.0, 0.0];
    for it in from {
        parameters.extend([(it.hz - units.hz) / units.width_hz, it.q.ln(), it.siemens / units.siemens]);
    }
    let mut squares = units.squares(&parameters, points);
    let mut damping = DAMPING.0;
    for _ in 0..STEPS.0 {
        let (matrix, right) = units.normal(&parameters, points);
        let mut damped = matrix;
        (0..number).for_each(|place| damped[(place, place)] *= 1.0 + damping);
        let step = damped.lu().solve(&right)?;
        let to: Vec<f64> = parameters.iter().zip(step.iter()).map(|(at, step)| at + step).collect();
        let then = if is_circuit(&units, &to) { units.squares(&to, points) } else { f64::INFINITY };
        if then < squares {
            let change = 1.0 - then / squares;
            (parameters, squares, damping) = (to, then, damping / DAMPING.1);
            if change < STEPS.1 {
                break;
            }
        } else if damping > 1e9 {
            break;
        } else {
            damping *= DAMPING.1;
        }
    }
    let (matrix, _) = units.normal(&parameters, points);
    // What the circuit leaves beside noise makes it less sure.
    let worse = (squares / free as f64).max(1.0).sqrt();
    let covariance = matrix.try_inverse()?;
    let deviation_hz = |place: usize| worse * covariance[(place, place)].max(0.0).sqrt() * units.width_hz;
    let deviations_hz = (0..from.len()).map(|n| deviation_hz(BACKGROUND + EACH * n)).collect();
    let resonances = parameters[BACKGROUND..].chunks(EACH).map(|of| units.resonance(of)).collect();
    let complex = |place: usize| units.siemens * Complex64::new(parameters[place], parameters[place + 1]);
    let background = (units.hz, complex(0), complex(2) / units.width_hz);
    Some(Fit { background, resonances, deviations_hz, squares, free })
}

/// Whether the parameters are those of passive resonances.
fn is_circuit(units: &Units, parameters: &[f64]) -> bool {
    parameters[BACKGROUND..].chunks(EACH).all(|of| {
        let it = units.resonance(of);
        it.siemens > 0.0 && it.hz > 0.0 && (QUALITIES.0..QUALITIES.1).contains(&it.q)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAIN: Resonance = Resonance { hz: 40e3, q: 50.0, siemens: 0.3 };

    /// Points to two bandwidths beside the main resonance, beside 300 nF, with a distance that changes its sign from point to point.
    fn points(further: &[Resonance], deviation: f64) -> Vec<Point> {
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
        let start = Resonance { hz: 40.1e3, q: 70.0, siemens: 0.25 };
        let fit = fit(&points(&[], 0.0), &[start]).unwrap();
        let found = fit.resonances[0];
        assert!((found.hz - MAIN.hz).abs() < 1e-3 && (found.q - 50.0).abs() < 1e-3, "{fit:?}");
        assert!((fit.c0_f() / 300e-9 - 1.0).abs() < 1e-6 && fit.mean_square() < 1e-3, "{fit:?}");
    }

    #[test]
    fn two_resonances_within_a_bandwidth_are_told_apart() {
        let further = Resonance { hz: 40.5e3, q: 80.0, siemens: 0.06 };
        let points = points(&[further], 1e-4);
        let one = fit(&points, &[MAIN]).unwrap();
        assert!(one.mean_square() > 30.0 && (one.resonances[0].hz - MAIN.hz).abs() > 20.0, "{one:?}");
        let two = fit(&points, &[one.resonances[0], Resonance { hz: 40.8e3, q: 50.0, siemens: 0.03 }]).unwrap();
        assert!(two.mean_square() < 2.0, "{two:?}");
        assert!((two.resonances[0].hz - MAIN.hz).abs() < 5.0 * two.deviations_hz[0] && two.deviations_hz[0] < 4.0, "{two:?}");
        assert!((two.resonances[1].hz - 40.5e3).abs() < 5.0 * two.deviations_hz[1], "{two:?}");
    }

    #[test]
    fn too_few_points_determine_nothing() {
        assert_eq!(fit(&points(&[], 0.0)[..2], &[MAIN]), None);
        assert_eq!(fit(&[], &[MAIN]), None);
    }
}
