//! Inverse law: the velocity ratio for a target friction ratio, computed in steps.
//!
//! For a contact at a given sliding speed, velocity ratio and kappa are not independent:
//! `kappa = lambda / xi` with
//!
//! ```text
//! lambda = Kt Vt / (w Fc) = Vt / (w l),    l = Fc / Kt  the Dahl length, m
//! ```
//!
//! The friction ratio therefore falls with the tip velocity alone, from one at `xi = 1` to the
//! **floor** at the maximum amplitude. In between, the solution is found by the Illinois rule
//! (Dowell and Jarratt 1971), which keeps it between two values. The unknown is `u = sqrt(1 - xi)`,
//! as a function of which the ratio has a finite slope: `(2/pi) asin xi` is approximately
//! `1 - (2/pi) sqrt(2) u` near one.
//!
//! Coulomb friction is `lambda = infinity`; the result is then `Vv / Vt = 1 / sin(pi r / 2)`.

use super::dahl::Evaluation;

/// Maximum deviation of a solution from the target ratio.
const RATIO_TOLERANCE: f32 = 1e-4;
/// Maximum number of evaluations; sufficient for any contact (see the tests).
const MAX_EVALUATIONS: u32 = 24;

/// Solution of the inverse law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Velocity ratio Vt / Vv to drive at.
    pub xi: f32,
    /// Friction ratio at this velocity ratio.
    pub(crate) ratio: f32,
    /// Minimum friction ratio, at the maximum amplitude; one without authority.
    pub floor: f32,
}

/// Solution in progress.
#[derive(Clone, Debug)]
pub(crate) struct Inverse {
    target: f32,
    lambda: f32,
    floor: f32,
    /// `u`, and the excess of the ratio over the target, where the excess is not negative.
    above: (f32, f32),
    /// `u`, and the excess of the ratio over the target, where the excess is negative.
    below: (f32, f32),
    /// `u` at which the ratio is being evaluated.
    at: f32,
    evaluation: Evaluation,
    evaluations: u32,
    /// Side that was replaced last.
    replaced: Option<Side>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Above,
    Below,
}

impl Inverse {
    /// Starts the search for the ratio `target`, with `xi` between `least_xi`, that of the maximum
    /// amplitude, and one. NaN is read as one.
    pub(crate) fn new(target: f32, lambda: f32, least_xi: f32) -> Self {
        let target = if target < 1.0 { target } else { 1.0 };
        let least_xi = if least_xi < 1.0 { least_xi.max(0.0) } else { 1.0 };
        let at = fpu::sqrtf(1.0 - least_xi);
        let evaluation = evaluation(at, lambda);
        let above = (0.0, 1.0 - target);
        Inverse { target, lambda, floor: 1.0, above, below: (at, 0.0), at, evaluation, evaluations: 0, replaced: None }
    }

    /// Advances by one step. Returns the solution once it is found.
    pub(crate) fn step(&mut self) -> Option<Solution> {
        let ratio = self.evaluation.step()?;
        let excess = ratio - self.target;
        self.evaluations += 1;
        if self.evaluations == 1 {
            self.floor = ratio;
            if excess >= -RATIO_TOLERANCE || self.above.1 <= RATIO_TOLERANCE {
                // The maximum amplitude is needed or not enough, or no reduction is commanded.
                let xi = if excess >= -RATIO_TOLERANCE { 1.0 - self.at * self.at } else { 1.0 };
                return Some(Solution { xi, ratio: if excess >= -RATIO_TOLERANCE { ratio } else { 1.0 }, floor: ratio });
            }
            self.below.1 = excess;
        } else {
            if excess.abs() < RATIO_TOLERANCE || self.evaluations >= MAX_EVALUATIONS {
                return Some(Solution { xi: 1.0 - self.at * self.at, ratio, floor: self.floor });
            }
            self.narrow(excess);
        }
        let part = self.above.1 / (self.above.1 - self.below.1);
        self.at = self.above.0 + part * (self.below.0 - self.above.0);
        self.evaluation = evaluation(self.at, self.lambda);
        None
    }

    /// Replaces one end. If the other end has been kept twice, its value is halved, so that it
    /// moves, too.
    fn narrow(&mut self, excess: f32) {
        let side = if excess > 0.0 { Side::Above } else { Side::Below };
        let again = self.replaced == Some(side);
        match side {
            Side::Above => {
                self.above = (self.at, excess);
                self.below.1 *= if again { 0.5 } else { 1.0 };
            }
            Side::Below => {
                self.below = (self.at, excess);
                self.above.1 *= if again { 0.5 } else { 1.0 };
            }
        }
        self.replaced = Some(side);
    }
}

fn evaluation(u: f32, lambda: f32) -> Evaluation {
    let xi = 1.0 - u * u;
    Evaluation::new(xi, lambda / xi)
}

/// Computes the solution in one call.
pub fn solve(target: f32, lambda: f32, least_xi: f32) -> Solution {
    let mut inverse = Inverse::new(target, lambda, least_xi);
    loop {
        if let Some(solution) = inverse.step() {
            return solution;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::dahl::{STEPS, friction_ratio};
    use super::*;

    fn lambdas() -> impl Iterator<Item = f32> {
        [0.0, f32::INFINITY].into_iter().chain((-24..=32).map(|n| libm::powf(10.0, 0.25 * n as f32)))
    }

    #[test]
    fn solution_has_the_target_ratio() {
        for lambda in lambdas() {
            for least_xi in [0.0, 0.05, 0.217, 0.6, 0.95] {
                for n in 1..100 {
                    let target = 0.01 * n as f32;
                    let solution = solve(target, lambda, least_xi);
                    let ratio = friction_ratio(solution.xi, lambda / solution.xi);
                    assert!((least_xi - 1e-6..=1.0).contains(&solution.xi), "{target} {lambda} {least_xi}: {solution:?}");
                    if target >= solution.floor {
                        assert!(
                            (ratio - target).abs() <= 1.01 * RATIO_TOLERANCE,
                            "{target} {lambda} {least_xi}: {solution:?} {ratio}"
                        );
                    } else {
                        assert!((solution.xi - least_xi).abs() < 1e-6 && solution.ratio == solution.floor, "{solution:?}");
                    }
                }
            }
        }
    }

    /// Measured: at most 11 evaluations.
    #[test]
    fn takes_few_evaluations() {
        let mut most = 0;
        for lambda in lambdas() {
            for least_xi in [0.0, 0.05, 0.217, 0.6, 0.95] {
                for n in 1..100 {
                    let mut inverse = Inverse::new(0.01 * n as f32, lambda, least_xi);
                    while inverse.step().is_none() {}
                    most = most.max(inverse.evaluations);
                }
            }
        }
        assert!(most <= 11, "{most} evaluations of {STEPS} steps");
    }

    /// More friction needs less vibration, for any contact.
    #[test]
    fn is_monotone() {
        for lambda in lambdas() {
            let ratios: std::vec::Vec<f32> = (20..100).map(|n| solve(0.01 * n as f32, lambda, 0.05).xi).collect();
            assert!(ratios.windows(2).all(|pair| pair[1] > pair[0] - 1e-6), "{lambda}: {ratios:?}");
        }
    }

    #[test]
    fn unreachable_target_gives_the_nearest_ratio() {
        let max_amplitude = solve(0.05, 0.3, 0.2);
        assert!(
            (max_amplitude.xi - 0.2).abs() < 1e-6 && max_amplitude.ratio > 0.05 && max_amplitude.ratio == max_amplitude.floor,
            "{max_amplitude:?}"
        );
        for target in [1.0, 1.5, f32::NAN, f32::INFINITY] {
            let silent = solve(target, 0.3, 0.2);
            assert!(silent.xi == 1.0 && silent.ratio == 1.0 && silent.floor < 0.5, "{target}: {silent:?}");
        }
        for least_xi in [1.0, 3.0, f32::NAN, f32::INFINITY] {
            assert_eq!(solve(0.3, 0.3, least_xi), Solution { xi: 1.0, ratio: 1.0, floor: 1.0 }, "{least_xi}");
        }
        for target in [-1.0, 0.0, f32::NEG_INFINITY] {
            assert!((solve(target, 0.3, 0.2).xi - 0.2).abs() < 1e-6, "{target}");
        }
        // At zero speed there is no sliding, and kappa is undefined.
        assert!(solve(0.5, 0.0, 0.0).xi > 0.0 && solve(0.5, f32::NAN, 0.2).ratio <= 1.0);
    }
}
