//! Cramér-Rao bounds of a synthetic measurement: the smallest standard deviations that its noise
//! permits.

use num_complex::Complex64;

use super::circuit::Equivalent;
use super::fit::Fitter;
use super::fixture::Fixture;
use super::measured::Measured;
use super::memory::whitened;
use super::result::{derived, propagated};
use super::weights::Weights;
use crate::least_squares::Solution;
use crate::synthetic::Noise;

/// Returns the values of the first branch: `fs`, `fp`, `Q`, `Rm`, `Lm`, `Cm`, `C0`, coupling.
pub(crate) fn values(truth: &Equivalent) -> [f64; 8] {
    let all = derived(&truth.parameters(truth.c0_f), truth.c0_f, 0);
    std::array::from_fn(|at| all[at])
}

/// Returns the Cramér-Rao bounds of the same values; `None` if the sweep does not determine them.
pub(crate) fn deviations(
    truth: &Equivalent,
    hz: &[f64],
    fixture: &[Fixture],
    noise: &Noise,
    sd: impl Fn(&Noise, Complex64) -> [f64; 2],
) -> Option<[f64; 8]> {
    let admittance: Vec<Complex64> = hz.iter().map(|hz| truth.admittance(*hz)).collect();
    let seen = |at: usize, y: Complex64| fixture.get(at).map_or(y, |fixture| fixture.seen(y).0);
    let seen: Vec<Complex64> = admittance.iter().enumerate().map(|(at, y)| seen(at, *y)).collect();
    let weights = Weights(seen.iter().map(|y| sd(noise, *y)).collect());
    let measured = Measured {
        hz: hz.to_vec(),
        seen: admittance.clone(),
        admittance,
        fixture: fixture.to_vec(),
        coordinate: noise.coordinate,
        remarks: Vec::new(),
    };
    let fitter = Fitter::new(&measured);
    let parameters = truth.parameters(fitter.farad);
    let linear = whitened(&fitter.linear(&parameters, &weights)?, noise.correlation);
    let covariance = Solution { parameters: parameters.clone(), linear, cost: 0.0, converged: true }.covariance()?;
    let (all, _) = propagated(&parameters, &covariance, |parameters| derived(parameters, fitter.farad, 0));
    Some(std::array::from_fn(|at| all[at].sd))
}
