//! Covariance of fitted parameters for correlated noise of neighbouring samples.
//!
//! ```text
//! C = m s^2 A^-1 B A^-1,   A = X'X,   B = X'RX,   R(i, j) = rho^|i - j|,   s^2 = r'r / (n - tr A^-1 B)
//! ```
//!
//! `X` are the derivatives and `r` the residuals of ordinary least squares, which stay close to the
//! measurement even if a model does not fit. The correlation `rho` of neighbours maximises the
//! restricted likelihood (D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320). The correlation of
//! the residuals themselves would be too small, because the fit has removed a part of the noise.
//! `m` is the remaining memory of the whitened residuals.
//!
//! A parameter that the log does not determine is not treated as known: its uncertainty increases
//! the standard deviations of the others.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::least_squares::Linear;
use crate::rows::{MAX_POINTS, memory};

/// Number added to the diagonal of matrices whose columns have unit length. An undetermined
/// direction then has a huge deviation, instead of an undefined one.
const RIDGE: f64 = 1e-12;
/// Largest tried correlation of neighbours.
const MAX_CORRELATION: f64 = 0.98;
/// Steps of the tried correlations: coarse, then fine around the best one.
const CORRELATION_STEPS: [f64; 2] = [0.05, 0.005];

/// Returns the covariance of the parameters. `places` are the ascending indices of the samples in
/// the log.
pub(super) fn covariance(linear: &Linear, places: &[usize]) -> Option<DMatrix<f64>> {
    let links = links(correlation(linear, places), places);
    let (matrix, _, scales) = linear.normal();
    let n = scales.len();
    let spread = correlated(&linear.columns, &links);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let ridge = |i: usize, j: usize| if i == j { RIDGE } else { 0.0 };
    let inverse = Cholesky::new(DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] + ridge(i, j)))?.inverse();
    let middle = |i: usize, j: usize| scales[i] * scales[j] * dot(&linear.columns[i.min(j)], &spread[i.max(j)]) + ridge(i, j);
    let mut middle = DMatrix::from_fn(n, n, |i, j| if i <= j { middle(i, j) } else { 0.0 });
    middle.fill_lower_triangle_with_upper_triangle();
    let product =
        |a: &DMatrix<f64>, b: &DMatrix<f64>| DMatrix::from_fn(n, n, |i, j| (0..n).map(|k| a[(i, k)] * b[(k, j)]).sum::<f64>());
    let half = product(&inverse, &middle);
    let whole = product(&half, &inverse);
    let count = linear.residuals.len() as f64;
    // A long memory leaves few independent samples; a tenth of all samples is the minimum.
    let free = (count - half.trace()).max(0.1 * count).max(1.0);
    let white = whitened(&Linear { residuals: linear.residuals.clone(), columns: Vec::new() }, &links);
    let variance = dot(&linear.residuals, &linear.residuals) / free * memory(&[&white.residuals]).1;
    let covariance = DMatrix::from_fn(n, n, |i, j| variance * scales[i] * scales[j] * 0.5 * (whole[(i, j)] + whole[(j, i)]));
    covariance.iter().all(|value| value.is_finite()).then_some(covariance)
}

/// Returns the standard deviation of a mean from the residuals about it.
pub(super) fn sd_of_mean(residuals: Vec<f64>, places: &[usize]) -> Option<f64> {
    let columns = vec![vec![1.0; residuals.len()]];
    Some(covariance(&Linear { residuals, columns }, places)?[(0, 0)].max(0.0).sqrt())
}

/// Returns the correlation of each sample with the preceding one; zero for the first.
pub(crate) fn links(rho: f64, places: &[usize]) -> Vec<f64> {
    let link = |at: usize| match at.checked_sub(1) {
        Some(before) if places[at] == places[before] + 1 => rho,
        Some(before) => libm::pow(rho, places[at].saturating_sub(places[before]) as f64),
        None => 0.0,
    };
    (0..places.len()).map(link).collect()
}

/// Whitens residuals and derivatives: subtracts a fraction of those of the preceding sample, and
/// keeps the variance.
pub(crate) fn whitened(linear: &Linear, links: &[f64]) -> Linear {
    let of = |values: &Vec<f64>| {
        let white = |at: usize| match links[at] {
            0.0 => values[at],
            link => (values[at] - link * values[at - 1]) / (1.0 - link * link).sqrt(),
        };
        (0..values.len()).map(white).collect()
    };
    Linear { residuals: of(&linear.residuals), columns: linear.columns.iter().map(of).collect() }
}

/// Multiplies columns by the matrix of correlations, in a forward and a backward pass.
fn correlated(columns: &[Vec<f64>], links: &[f64]) -> Vec<Vec<f64>> {
    let of = |column: &Vec<f64>| {
        let n = column.len();
        let mut sums = vec![0.0; n];
        let mut before = 0.0;
        for at in 0..n {
            before = links[at] * before + column[at];
            sums[at] = before;
        }
        let mut behind = 0.0;
        for at in (0..n).rev() {
            sums[at] += behind;
            behind = links[at] * (behind + column[at]);
        }
        sums
    };
    columns.iter().map(of).collect()
}

/// Returns the correlation of neighbours with the greatest restricted likelihood, from the middle
/// of a long log.
fn correlation(linear: &Linear, places: &[usize]) -> f64 {
    let from = places.len().saturating_sub(MAX_POINTS) / 2;
    let rows = from..places.len().min(from + MAX_POINTS);
    let part = |values: &Vec<f64>| values[rows.clone()].to_vec();
    let linear = &Linear { residuals: part(&linear.residuals), columns: linear.columns.iter().map(part).collect() };
    let places = &places[rows.clone()];
    let mut best = (f64::INFINITY, 0.0);
    for step in CORRELATION_STEPS {
        let (coarse, middle) = (step == CORRELATION_STEPS[0], best.1);
        let (from, to) =
            if coarse { (0.0, MAX_CORRELATION) } else { (middle - CORRELATION_STEPS[0], middle + CORRELATION_STEPS[0]) };
        for n in 0..=((to - from) / step) as usize {
            let rho = from + step * n as f64;
            let deviance = if (0.0..=MAX_CORRELATION).contains(&rho) { deviance(linear, &links(rho, places)) } else { None };
            if let Some(deviance) = deviance.filter(|deviance| *deviance < best.0) {
                best = (deviance, rho);
            }
        }
    }
    best.1
}

/// Returns minus twice the logarithm of the restricted likelihood,
/// `ln|R| + ln|X'R^-1 X| + (n - p) ln(r'Pr)`, without terms that do not depend on the correlation.
fn deviance(linear: &Linear, links: &[f64]) -> Option<f64> {
    let white = whitened(linear, links);
    let (matrix, gradient, scales) = white.normal();
    let (n, p) = (white.residuals.len(), scales.len());
    let factor: Cholesky<f64, Dyn> =
        Cholesky::new(DMatrix::from_fn(p, p, |i, j| matrix[(i, j)] + if i == j { RIDGE } else { 0.0 }))?;
    let step: DVector<f64> = factor.solve(&gradient);
    let square = white.residuals.iter().map(|r| r * r).sum::<f64>() - gradient.dot(&step);
    let of_noise: f64 = links.iter().map(|link| libm::log(1.0 - link * link)).sum();
    let of_columns: f64 = (0..p).map(|i| 2.0 * libm::log(factor.l_dirty()[(i, i)] / scales[i])).sum();
    let free = n.saturating_sub(p).max(1) as f64;
    Some(of_noise + of_columns + free * libm::log(square.max(f64::MIN_POSITIVE)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::random::Random;

    /// Fits the slope of a line through the origin to correlated noise, and returns it with its
    /// stated standard deviation.
    fn slope(random: &mut Random, rho: f64) -> (f64, f64) {
        let mut last = random.normal();
        let x: Vec<f64> = (0..300).map(|n| libm::sin(f64::from(n) * 0.05)).collect();
        let noise = |_: &f64| {
            let now = last;
            last = rho * last + (1.0 - rho * rho).sqrt() * random.normal();
            now
        };
        let y: Vec<f64> = x.iter().map(noise).collect();
        let square: f64 = x.iter().map(|x| x * x).sum();
        let slope = x.iter().zip(&y).map(|(x, y)| x * y).sum::<f64>() / square;
        let residuals = x.iter().zip(&y).map(|(x, y)| slope * x - y).collect();
        let places: Vec<usize> = (0..300).collect();
        (slope, covariance(&Linear { residuals, columns: vec![x] }, &places).unwrap()[(0, 0)].sqrt())
    }

    #[test]
    fn stated_deviations_agree_with_many_noise_draws() {
        for rho in [0.0, 0.5, 0.9] {
            let mut random = Random::new(7);
            let drawn: Vec<(f64, f64)> = (0..400).map(|_| slope(&mut random, rho)).collect();
            let within = drawn.iter().filter(|(error, sd)| error.abs() <= 2.0 * sd).count() as f64 / 400.0;
            assert!((0.93..=0.98).contains(&within), "{rho}: {within}");
        }
    }

    #[test]
    fn collinear_parameters_are_undetermined() {
        let residuals: Vec<f64> = (0..50).map(|n| f64::from(n % 2) - 0.5).collect();
        let columns = vec![vec![1.0; 50], vec![2.0; 50], (0..50).map(f64::from).collect()];
        let places: Vec<usize> = (0..50).collect();
        let covariance = covariance(&Linear { residuals, columns }, &places).unwrap();
        assert!(covariance[(0, 0)] > 1e6 && covariance[(1, 1)] > 1e6 && covariance[(2, 2)] < 1e-3, "{covariance}");
    }

    #[test]
    fn correlation_decays_over_a_gap_in_the_samples() {
        assert_eq!(links(0.5, &[3, 4, 7]), [0.0, 0.5, 0.125]);
        let columns = [vec![1.0, 2.0, 4.0]];
        // R = [1 .5 .0625; .5 1 .125; .0625 .125 1].
        assert_eq!(correlated(&columns, &links(0.5, &[3, 4, 7]))[0], [2.25, 3.0, 4.3125]);
    }
}
