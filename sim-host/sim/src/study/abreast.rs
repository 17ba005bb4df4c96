//! Contact studies that have a closed form, many at once: the means of a steady sine follow from two numbers, and are computed in SIMD lanes.

use contact::{self, Numerics, Problem, closed, lanes};
use scene::{Excited, problem};

/// A study that is solved beside others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steady {
    point: closed::Point,
    coulomb_n: f64,
}

/// A metric that follows from the means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mean {
    FrictionRatio,
    ReductionPercent,
    FrictionOnN,
    PowerRatio,
}

impl Mean {
    /// The metric of this name, if it is one of these.
    pub(super) fn named(metric: &str) -> Option<Self> {
        Some(match metric {
            "friction_ratio" => Mean::FrictionRatio,
            "reduction_percent" => Mean::ReductionPercent,
            "friction_on_n" => Mean::FrictionOnN,
            "power_ratio" => Mean::PowerRatio,
            _ => return None,
        })
    }

    /// The metric of each study, as [`metrics`](crate::study::contact::metrics) has it; none where a study has no power ratio.
    pub(super) fn of(self, studies: &[Steady]) -> Vec<Option<f64>> {
        let points: Vec<(f64, f64)> = studies.iter().map(|study| (study.point.velocity_ratio, study.point.kappa)).collect();
        let ratios = if self == Mean::PowerRatio { lanes::power_ratios(&points) } else { lanes::friction_ratios(&points) };
        let metric = |(study, ratio): (&Steady, f64)| match self {
            Mean::FrictionRatio => Some(ratio),
            Mean::ReductionPercent => Some(100.0 * (1.0 - ratio)),
            Mean::FrictionOnN => Some(ratio * study.coulomb_n),
            // Over Fc Vt, which is negative where the sliding is.
            Mean::PowerRatio => Some(ratio * study.point.velocity_ratio.signum()).filter(|ratio| !ratio.is_nan()),
        };
        studies.iter().zip(ratios).map(metric).collect()
    }
}

/// The study of a scene that has a closed form for a sine and is to be solved by it; none of any other.
pub(super) fn steady(scene: &Excited) -> Option<Steady> {
    let problem = problem::problem(scene, problem::law(&scene.model)?).ok()?;
    of_problem(&problem, &problem::numerics(scene, None))
}

/// The same of a problem.
pub(super) fn of_problem(problem: &Problem, numerics: &Numerics) -> Option<Steady> {
    let point = contact::closed_point(problem, numerics)?;
    Some(Steady { point, coulomb_n: problem.coulomb_n })
}
