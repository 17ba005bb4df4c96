//! Velocity from a displacement with noise: the slope of a cubic fitted to neighbouring samples.
//!
//! ```text
//! x(t) = c0 + c1 s + c2 s^2 + c3 s^3,   s = (t - ti) / T,   v = c1 / T
//! sd(v) = sd(x) sqrt(A^-1(1,1)) / T,   A = sum s^(i + j)
//! ```
//!
//! The number of samples is the largest, from five to 33, for which the residuals of the cubic are
//! noise: smooth parts of the motion have long cubics, reversals short ones. The noise follows from
//! differences of the sixth order, to which a motion contributes little (O. V. Lepskii, Theory
//! Probab. Appl. 35 (1991) 454; A. Savitzky, M. Golay, Anal. Chem. 36 (1964) 1627). A displacement
//! without noise is not changed.

use nalgebra::{Matrix4, Vector4};

use report::significant;
use report::statistics::{ascending, quantile};

/// Smallest number of samples to each side of a cubic.
const MIN_HALF: usize = 2;
/// Largest number of samples to each side of a cubic.
const MAX_HALF: usize = 16;
/// Largest mean interval of a cubic, relative to the nearer neighbour of its sample.
const MAX_UNEVEN: f64 = 4.0;
/// Number of neighbours in a difference of the sixth order.
const ORDER: usize = 7;
/// Maximum number of differences from which the noise is estimated.
const MAX_DIFFERENCES: usize = 20_000;
/// Median of the size of normal noise, standard deviations.
const NORMAL_MEDIAN: f64 = 0.674_5;
/// Largest normal deviation of a sum of squares that is noise.
const MAX_SIGMAS: f64 = 3.7;

/// Displacement and velocity without most of their noise.
pub(crate) struct Smoothed {
    /// Displacement of each sample, m.
    pub(crate) x_m: Vec<f64>,
    /// Velocity of each sample, m/s.
    pub(crate) velocity_m_per_s: Vec<f64>,
    /// Standard deviation of the noise of a measured displacement, m.
    pub(super) noise_m: f64,
    /// Standard deviation of the noise of the velocity, m/s.
    pub(super) velocity_noise_m_per_s: f64,
}

/// Cubic at a sample.
struct Cubic {
    x: f64,
    slope: f64,
    /// Sum of the squares of the residuals.
    square: f64,
    /// Standard deviation of the slope for noise of size one.
    gain: f64,
}

impl Smoothed {
    /// Differentiates a displacement of ascending times.
    pub(crate) fn new(time_s: &[f64], x: &[f64]) -> Self {
        let noise_m = noise(time_s, x);
        let count = x.len();
        let (x_m, velocity_m_per_s) = (x.to_vec(), vec![0.0; count]);
        let mut smoothed = Smoothed { x_m, velocity_m_per_s, noise_m, velocity_noise_m_per_s: 0.0 };
        let (mut square, mut half) = (0.0, MIN_HALF);
        for at in 0..count {
            half = (2 * half).min(MAX_HALF);
            let best = loop {
                let found = cubic(time_s, x, at, half);
                let is_noise = |free: usize, square: f64| square <= noise_m * noise_m * largest_square(free);
                match found {
                    Some((cubic, free)) if half == MIN_HALF || is_noise(free, cubic.square) => break cubic,
                    None if half == MIN_HALF => break quotient(time_s, x, at),
                    _ => half /= 2,
                }
            };
            // The shortest cubic does not change a displacement without noise.
            if half > MIN_HALF {
                smoothed.x_m[at] = best.x;
            }
            smoothed.velocity_m_per_s[at] = best.slope;
            square += (best.gain * noise_m).powi(2) / count as f64;
        }
        smoothed.velocity_noise_m_per_s = square.sqrt();
        smoothed
    }

    /// Returns the noise, as a sentence.
    pub(super) fn remark(&self) -> String {
        format!(
            "The velocity is the slope of the displacement over 5 to 33 samples: its noise is {} m/s, for {} m of the \
             displacement",
            significant(self.velocity_noise_m_per_s),
            significant(self.noise_m)
        )
    }
}

/// Returns the interval to the nearer neighbour of a sample.
fn nearest(time_s: &[f64], at: usize) -> (usize, usize) {
    let before = (at.max(1) - 1, at.max(1));
    let after = (at.min(time_s.len() - 2), at.min(time_s.len() - 2) + 1);
    if time_s[before.1] - time_s[before.0] <= time_s[after.1] - time_s[after.0] { before } else { after }
}

/// Returns the difference quotient at a sample, for the edge of a gap.
fn quotient(time_s: &[f64], x: &[f64], at: usize) -> Cubic {
    let (from, to) = nearest(time_s, at);
    let interval = time_s[to] - time_s[from];
    Cubic { x: x[at], slope: (x[to] - x[from]) / interval, square: 0.0, gain: 2.0_f64.sqrt() / interval }
}

/// Fits a cubic around a sample, and returns it with its degrees of freedom; `None` if there are
/// too few samples, or a gap between them.
fn cubic(time_s: &[f64], x: &[f64], at: usize, half: usize) -> Option<(Cubic, usize)> {
    let least = 2 * MIN_HALF + 1;
    let from = at.saturating_sub(half).min(x.len().checked_sub(least)?);
    let rows = from..(at + half + 1).max(from + least).min(x.len());
    let (near, far) = nearest(time_s, at);
    if time_s[rows.end - 1] - time_s[rows.start] > MAX_UNEVEN * rows.len() as f64 * (time_s[far] - time_s[near]) {
        return None;
    }
    let unit = 0.5 * (time_s[rows.end - 1] - time_s[rows.start]);
    let (mut s, mut t) = ([0.0; 7], [0.0; 4]);
    let place = |row: usize| ((time_s[row] - time_s[at]) / unit, x[row] - x[at]);
    for row in rows.clone() {
        let (u, y) = place(row);
        let mut power = 1.0;
        for k in 0..7 {
            s[k] += power;
            if k < 4 {
                t[k] += power * y;
            }
            power *= u;
        }
    }
    let inverse = Matrix4::from_fn(|i, j| s[i + j]).try_inverse()?;
    let c = inverse * Vector4::from(t);
    let error = |row: usize| {
        let (u, y) = place(row);
        c[0] + u * (c[1] + u * (c[2] + u * c[3])) - y
    };
    let square = rows.clone().map(|row| error(row) * error(row)).sum();
    let cubic = Cubic { x: x[at] + c[0], slope: c[1] / unit, square, gain: inverse[(1, 1)].max(0.0).sqrt() / unit };
    Some((cubic, rows.len() - 4))
}

/// Returns the largest sum of squares of noise of size one with this number of degrees of freedom
/// (E. B. Wilson, M. M. Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684).
fn largest_square(free: usize) -> f64 {
    let part = 2.0 / (9.0 * free as f64);
    free as f64 * (1.0 - part + MAX_SIGMAS * part.sqrt()).powi(3)
}

/// Returns the standard deviation of the noise of a displacement, from divided differences of the
/// sixth order.
fn noise(time_s: &[f64], x: &[f64]) -> f64 {
    let last = (x.len() + 1).saturating_sub(ORDER);
    let difference = |at: usize| {
        let (mut sum, mut square) = (0.0, 0.0);
        for i in 0..ORDER {
            let others = (0..ORDER).filter(|j| *j != i);
            // In units of the whole interval, so that no product overflows.
            let unit = time_s[at + ORDER - 1] - time_s[at];
            let weight: f64 = others.map(|j| unit / (time_s[at + i] - time_s[at + j])).product();
            sum += weight * (x[at + i] - x[at]);
            square += weight * weight;
        }
        sum.abs() / square.sqrt()
    };
    let differences = ascending((0..last).step_by(last / MAX_DIFFERENCES + 1).map(difference).filter(|size| *size > 0.0));
    quantile(&differences, 0.5).unwrap_or(0.0) / NORMAL_MEDIAN
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::random::Random;

    #[test]
    fn noise_of_a_displacement_does_not_hide_its_velocity() {
        let mut random = Random::new(5);
        let (w, a) = (std::f64::consts::TAU, 2e-3);
        // With uneven intervals, and a pause of 100 s in the middle.
        let time = |n: u32| 5e-3 * (f64::from(n) + random.between(-0.2, 0.2)) + if n < 1000 { 0.0 } else { 100.0 };
        let time: Vec<f64> = (0..2000).map(time).collect();
        for noise in [0.0, 2e-6] {
            let x: Vec<f64> = time.iter().map(|t| a * libm::sin(w * t) + noise * random.normal()).collect();
            let smoothed = Smoothed::new(&time, &x);
            let error = |at: usize| smoothed.velocity_m_per_s[at] - a * w * libm::cos(w * time[at]);
            let rms = ((0..2000).map(|at| error(at).powi(2)).sum::<f64>() / 2000.0).sqrt();
            // The noise is a small part of that of a difference of neighbours.
            let difference = 2.0_f64.sqrt() * noise / 5e-3;
            assert!(rms < 0.15 * difference + 2e-6, "{noise}: {rms}");
            assert!((smoothed.noise_m - noise).abs() < 0.1 * noise + 1e-10, "{}", smoothed.noise_m);
            assert!(
                (smoothed.velocity_noise_m_per_s - rms).abs() < 0.4 * rms || noise == 0.0,
                "{rms} {}",
                smoothed.velocity_noise_m_per_s
            );
            assert_eq!(smoothed.x_m[50] == x[50], noise == 0.0);
        }
    }
}
