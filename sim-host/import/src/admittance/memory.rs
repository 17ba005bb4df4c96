//! Correlation of neighbouring residuals, called memory, and whitening of a fit.

use num_complex::Complex64;

use crate::least_squares::Linear;

/// Converts residuals to complex numbers.
pub(super) fn complex(residuals: &[f64]) -> Vec<Complex64> {
    let (re, im) = residuals.split_at(residuals.len() / 2);
    re.iter().zip(im).map(|(re, im)| Complex64::new(*re, *im)).collect()
}

/// Whitens residuals and derivatives: subtracts a fraction of those of the preceding point, and
/// keeps the variance.
pub(super) fn whitened(linear: &Linear, rho: f64) -> Linear {
    let half = linear.residuals.len() / 2;
    let scale = 1.0 / (1.0 - rho * rho).sqrt();
    let of = |values: &Vec<f64>| {
        let white = |at: usize| if at.is_multiple_of(half) { values[at] } else { (values[at] - rho * values[at - 1]) * scale };
        (0..values.len()).map(white).collect()
    };
    Linear { residuals: of(&linear.residuals), columns: linear.columns.iter().map(of).collect() }
}

/// Returns the correlation of neighbours, and the factor of the variance due to all significant
/// correlations.
pub(super) fn memory(residuals: &[Complex64]) -> (f64, f64) {
    let (re, im): (Vec<f64>, Vec<f64>) = residuals.iter().map(|e| (e.re, e.im)).unzip();
    crate::rows::memory(&[&re, &im])
}

/// Sum of the squared weights of a third difference, 1 + 9 + 9 + 1.
pub(super) const ROUGHNESS_WEIGHT: f64 = 20.0;

/// Returns the variance of residuals relative to that of noise with the same third differences; 1
/// for noise.
pub(super) fn roughness(residuals: &[Complex64]) -> f64 {
    let differences = residuals.windows(4).map(|e| (e[0] - 3.0 * e[1] + 3.0 * e[2] - e[3]).norm_sqr() / ROUGHNESS_WEIGHT);
    let count = residuals.len().saturating_sub(3).max(1) as f64;
    let rough = differences.sum::<f64>() / count;
    let whole = residuals.iter().map(Complex64::norm_sqr).sum::<f64>() / residuals.len().max(1) as f64;
    if rough > 0.0 { whole / rough } else { 1.0 }
}
