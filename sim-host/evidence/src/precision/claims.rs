//! Claims as cost ratios read from the work-precision curves, with their verdicts.

use std::hint::black_box;
use std::time::Instant;

use super::interpolate::cost_at;
use super::method::Role;
use super::work::{Curve, Point};
use contact::closed;
use contact::table_4_1::{VELOCITY_RATIO, table_4_1};

/// Claim with its measured values.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// The claim in words.
    pub what: String,
    /// Methods and settings that were compared.
    pub how: String,
    /// Bound on the measured value.
    pub target: Target,
    /// Value by time; `None` if not measured.
    pub by_time: Option<f64>,
    /// Value by instructions; `None` if not counted.
    pub by_instructions: Option<f64>,
}

/// Bound on the measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// Smallest speed-up, as a factor.
    Times(f64),
    /// Longest time, ns.
    Nanoseconds(f64),
}

impl Claim {
    /// Returns `true` if the claim holds by time; `None` if it was not measured.
    pub fn holds(&self) -> Option<bool> {
        self.by_time.map(|measured| match self.target {
            Target::Times(target) => measured >= target,
            Target::Nanoseconds(target) => measured <= target,
        })
    }
}

/// Speed-ups at equal error of F: error, role of the methods compared with, and smallest factor.
const AT_EQUAL_ERROR: [(f64, Role, f64); 4] =
    [(1e-6, Role::Fair, 25.0), (1e-6, Role::Plain, 50.0), (1e-8, Role::Fair, 80.0), (1e-8, Role::Plain, 160.0)];
/// Steps a period of the thesis.
const THESIS_STEPS: u32 = 1000;
/// Method that is compared with the thesis's step.
const SWIFT_METHOD: &str = "linexp-2";
/// Steps a period of that method.
const SWIFT_STEPS: u32 = 8;
/// Smallest speed-up over the thesis's step.
const THESIS_STEP_SPEED_UP: f64 = 40.0;

/// Judges all claims from the measured curves.
pub fn judge(curves: &[Curve]) -> Vec<Claim> {
    let mut claims: Vec<Claim> =
        AT_EQUAL_ERROR.iter().map(|&(error, role, target)| equal_error(curves, error, role, target)).collect();
    claims.push(thesis_step(curves));
    claims.push(closed_form());
    claims
}

const BY_TIME: fn(&Point) -> Option<f64> = |point| Some(point.ns);
const BY_INSTRUCTIONS: fn(&Point) -> Option<f64> = |point| point.instructions;

/// Returns the lowest cost among the methods of a role at an error of F, and the method's name.
fn cheapest(curves: &[Curve], role: Role, error: f64, cost: fn(&Point) -> Option<f64>) -> Option<(f64, &'static str)> {
    let of =
        |curve: &Curve| Some((cost_at(&curve.cost_against_error(cost, |point| point.errors.force), error)?, curve.method.name));
    curves.iter().filter(|curve| curve.method.role == role).filter_map(of).min_by(|a, b| a.0.total_cmp(&b.0))
}

fn equal_error(curves: &[Curve], error: f64, role: Role, target: f64) -> Claim {
    let pair = |cost| cheapest(curves, Role::Ours, error, cost).zip(cheapest(curves, role, error, cost));
    let ratio = |cost| pair(cost).map(|(ours, theirs)| theirs.0 / ours.0);
    let who = if role == Role::Fair { "RK4, fair" } else { "RK4, plain" };
    let how = pair(BY_TIME).map_or_else(
        || "one of the curves does not reach this error".to_owned(),
        |(ours, theirs)| format!("{} {:.0} ns, {} {:.0} ns", ours.1, ours.0, theirs.1, theirs.0),
    );
    Claim {
        what: format!("speed-up over {who}, at an error of F of {error:.0e}"),
        how,
        target: Target::Times(target),
        by_time: ratio(BY_TIME),
        by_instructions: ratio(BY_INSTRUCTIONS),
    }
}

fn thesis_step(curves: &[Curve]) -> Claim {
    let ours = curves.iter().find(|curve| curve.method.name == SWIFT_METHOD).and_then(|curve| curve.at(SWIFT_STEPS));
    let fair = curves.iter().find(|curve| curve.method.role == Role::Fair).and_then(|curve| curve.at(THESIS_STEPS));
    let ratio = |cost: fn(&Point) -> Option<f64>| Some(cost(fair?)? / cost(ours?)?);
    let how = ours.zip(fair).map(|(ours, fair)| format!("{} {:.0} ns, rk4-fair {:.0} ns", SWIFT_METHOD, ours.ns, fair.ns));
    Claim {
        what: format!("{} at {} steps over RK4, fair, at the thesis's {THESIS_STEPS} steps", SWIFT_METHOD, SWIFT_STEPS),
        how: how.unwrap_or_default(),
        target: Target::Times(THESIS_STEP_SPEED_UP),
        by_time: ratio(BY_TIME),
        by_instructions: ratio(BY_INSTRUCTIONS),
    }
}

/// Times the steady kinematic friction ratio in closed form; mean of many calls, ns.
fn closed_form() -> Claim {
    const CALLS: u32 = 2000;
    let problem = table_4_1(VELOCITY_RATIO, 1.0);
    let kappa = problem.kappa();
    let round = || {
        let began = Instant::now();
        for call in 0..CALLS {
            black_box(closed::friction_ratio(black_box(VELOCITY_RATIO + 1e-6 * f64::from(call)), black_box(kappa)));
        }
        began.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS)
    };
    let least = (0..5).map(|_| round()).fold(f64::INFINITY, f64::min);
    Claim {
        what: "time for the steady kinematic Dahl friction ratio in closed form, ns".into(),
        how: format!("kappa {kappa:.3}, mean of {CALLS} velocity ratios"),
        target: Target::Nanoseconds(1000.0),
        by_time: Some(least),
        by_instructions: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::method::METHODS;
    use crate::precision::sample::Errors;

    fn curve(name: &str, points: &[(u32, f64, f64)]) -> Curve {
        let method = METHODS.iter().find(|method| method.name == name).unwrap();
        let point = |&(steps, ns, force): &(u32, f64, f64)| Point {
            steps,
            ns,
            instructions: Some(3.0 * ns),
            errors: Errors { force, ..Errors::default() },
        };
        Curve { method, points: points.iter().map(point).collect() }
    }

    #[test]
    fn a_ratio_uses_our_cheapest_method() {
        let curves = [
            curve("linexp-2", &[(8, 500.0, 1e-5), (16, 1000.0, 1e-7)]),
            curve("taylor-12", &[(8, 2000.0, 1e-9)]),
            curve("rk4-fair", &[(1000, 25e3, 1e-6), (10_000, 250e3, 1e-8)]),
        ];
        let claims = judge(&curves);
        let at_1e_6 = 25e3 / (500.0 * 1000.0f64).sqrt();
        assert!((claims[0].by_time.unwrap() / at_1e_6 - 1.0).abs() < 1e-12 && claims[0].holds() == Some(true));
        assert!((claims[0].by_instructions.unwrap() / at_1e_6 - 1.0).abs() < 1e-12);
        // At 1e-8 only the series is accurate enough; plain was not measured.
        assert!((claims[2].by_time.unwrap() - 125.0).abs() < 1e-9 && claims[2].holds() == Some(true));
        assert_eq!((claims[1].by_time, claims[1].holds()), (None, None));
        assert_eq!((claims[4].by_time, claims[4].holds()), (Some(50.0), Some(true)));
    }

    #[test]
    fn a_claim_can_be_missed() {
        let curves = [curve("linexp-2", &[(8, 500.0, 1e-7)]), curve("rk4-fair", &[(1000, 10e3, 1e-7)])];
        let claims = judge(&curves);
        assert_eq!((claims[0].holds(), claims[4].holds()), (Some(false), Some(false)));
    }
}
