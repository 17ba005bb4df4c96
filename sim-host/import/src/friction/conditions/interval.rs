//! Intervals of all results, by the profile of the likelihood over the stiffness.
//!
//! A value `q` is in the interval if some stiffness `s` explains the measurements and `q`:
//!
//! ```text
//! rise(s) / t(ON)^2 + (q - q(s))^2 / (t(q)^2 var(q at s)) <= 1
//! ```
//!
//! `rise` is the increase of the weighted sum of squares over its minimum, and `t` the quantile of
//! Student (W. Q. Meeker, L. A. Escobar, Am. Stat. 49 (1995) 48). The probability of a stiffness
//! would depend on its prior: a rigid contact has a long range of stiffnesses that are all equally
//! good, and would outweigh a softer contact that is as good in a narrow range.
//!
//! The degrees of freedom of `q` are those of the scatter of OFF and ON, in proportion to their
//! shares of the variance (F. E. Satterthwaite, Biometrics Bull. 2 (1946) 110).

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Cholesky, DVector};

use super::fit::{Fit, Slice};
use super::model::Parameters;

/// Probability of an interval.
const INTERVAL: f64 = 0.95;
/// Largest number of degrees of freedom; more are equal to infinitely many.
pub(super) const MAX_FREEDOM: f64 = 400.0;
/// Step of a parameter for a derivative.
const STEP: f64 = 1e-6;

/// Value with an interval that contains the truth with a probability of 95 %.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Interval {
    /// Value.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Value at one stiffness.
struct Local {
    value: f64,
    /// Change of the fitted parameters that changes the value by its standard deviation.
    step: DVector<f64>,
    /// Variance from the fit, and from the scatter of a new measurement.
    variances: [f64; 2],
    freedom: f64,
}

/// Returns the interval of a value of the parameters.
pub(super) fn interval(fit: &Fit, of: impl Fn(&Parameters) -> f64) -> Interval {
    within(fit, [0.0; 2], of)
}

/// Returns the interval of the ratio of a single new measurement ON to one OFF.
pub(super) fn interval_of_new(fit: &Fit, of: impl Fn(&Parameters) -> f64) -> Interval {
    within(fit, fit.scatter, of)
}

fn within(fit: &Fit, scatter: [f64; 2], of: impl Fn(&Parameters) -> f64) -> Interval {
    let value = |slice: &Slice, fitted: &[f64]| of(&fit.model.parameters(fitted, slice.ln_compliance));
    let locals: Vec<Option<Local>> = fit.slices.iter().map(|slice| local(fit, slice, scatter, |f| value(slice, f))).collect();
    let t = student(locals[fit.best].as_ref().map_or(f64::INFINITY, |local| local.freedom));
    let mut values = vec![value(&fit.slices[fit.chosen], &fit.slices[fit.chosen].fitted)];
    for (slice, local) in fit.slices.iter().zip(&locals) {
        let (Some(local), true) = (local, slice.rise < fit.max_rise) else { continue };
        let sigmas = t * (1.0 - slice.rise / fit.max_rise).sqrt();
        let [of_fit, of_new] = local.variances;
        let sd = (of_fit + of_new).sqrt().max(f64::MIN_POSITIVE);
        for sigmas in [-sigmas, sigmas] {
            let step = &local.step * (sigmas * of_fit.sqrt() / sd);
            let fitted: Vec<f64> = slice.fitted.iter().zip(step.iter()).map(|(value, step)| value + step).collect();
            values.push(value(slice, &fitted) + sigmas * of_new / sd);
        }
    }
    // The stiffness at which the rise reaches its limit lies between two slices.
    for (pair, locals) in fit.slices.windows(2).zip(locals.windows(2)) {
        let [from, to] = [pair[0].rise, pair[1].rise].map(|rise| rise - fit.max_rise);
        if let ([Some(a), Some(b)], true) = (locals, from * to < 0.0) {
            values.push(a.value + (b.value - a.value) * from / (from - to));
        }
    }
    let value = values[0];
    let all = || values.iter().copied().filter(|value| value.is_finite());
    Interval { value, low: all().fold(value, f64::min), high: all().fold(value, f64::max) }
}

/// Returns a value at one stiffness, with its variance; `None` if it is undefined.
fn local(fit: &Fit, slice: &Slice, scatter: [f64; 2], of: impl Fn(&[f64]) -> f64) -> Option<Local> {
    let value = of(&slice.fitted);
    let slope = |n: usize| {
        let moved: Vec<f64> = slice.fitted.iter().enumerate().map(|(m, p)| p + if m == n { STEP } else { 0.0 }).collect();
        (of(&moved) - value) / STEP
    };
    let gradient = DVector::from_fn(slice.fitted.len(), |n, _| slope(n));
    let weighted = Cholesky::new(&slice.matrices[0] + &slice.matrices[1])?.solve(&gradient);
    let of_fit = [0, 1].map(|state| weighted.dot(&(&slice.matrices[state] * &weighted)));
    let of_new = scatter.map(|scatter| (scatter * value).powi(2));
    let variances = [of_fit, of_new].map(|[off, on]| off + on);
    let total = variances[0] + variances[1];
    let share = |state: usize| (of_fit[state] + of_new[state]) / total;
    // Both groups share one scatter if either is too small.
    let freedom = match total > 0.0 && fit.freedom[0] != fit.freedom[1] {
        true => 1.0 / [0, 1].map(|state| share(state).powi(2) / fit.freedom[state]).iter().sum::<f64>(),
        false => fit.freedom[1],
    };
    let step = weighted / variances[0].sqrt().max(f64::MIN_POSITIVE);
    value.is_finite().then_some(Local { value, step, variances, freedom })
}

/// Returns the deviation, in estimated standard deviations, within which a value lies with the
/// probability of an interval. With `x = sqrt(n) tan a`, the density of Student is `cos(a)^(n-1)`.
pub(super) fn student(freedom: f64) -> f64 {
    const STEPS: usize = 2000;
    let freedom = freedom.min(MAX_FREEDOM);
    let step = FRAC_PI_2 / STEPS as f64;
    let density = |n: usize| libm::pow(libm::cos(step * (n as f64 + 0.5)), freedom - 1.0);
    let part = INTERVAL * (0..STEPS).map(density).sum::<f64>();
    let (mut sum, mut at) = (0.0, 0);
    while sum + density(at) < part {
        sum += density(at);
        at += 1;
    }
    freedom.sqrt() * libm::tan(step * (at as f64 + (part - sum) / density(at)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_student_are_those_of_tables() {
        for (freedom, quantile) in [(2.0, 4.303), (5.0, 2.571), (30.0, 2.042), (f64::INFINITY, 1.966)] {
            assert!((student(freedom) / quantile - 1.0).abs() < 1e-3, "{freedom}: {}", student(freedom));
        }
    }
}
