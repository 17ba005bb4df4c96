//! Contact studies that have a closed form: the means of a steady sine follow from two numbers.

use contact::closed::ClosedForm;
use contact::{Numerics, Problem, Shape, closed};
use scene::{Excited, problem};

/// A study of a steady sine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steady {
    velocity_ratio: f64,
    kappa: f64,
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

    /// The metric of a study, as [`metrics`](crate::study::contact::metrics) has it; none where a study has no power ratio.
    pub(super) fn of(self, study: &Steady) -> Option<f64> {
        let Steady { velocity_ratio, kappa, .. } = *study;
        let ratio = || closed::friction_ratio(velocity_ratio, kappa);
        match self {
            Mean::FrictionRatio => Some(ratio()),
            Mean::ReductionPercent => Some(100.0 * (1.0 - ratio())),
            Mean::FrictionOnN => Some(ratio() * study.coulomb_n),
            // Over Fc Vt, which is negative where the sliding is.
            Mean::PowerRatio => Some(closed::power_ratio(velocity_ratio, kappa)? * velocity_ratio.signum()),
        }
    }
}

/// The study of a scene that has a closed form for a sine and is to be solved by it; none of any other.
pub(super) fn of(scene: &Excited) -> Option<Steady> {
    if problem::direction(scene).is_some() {
        return None;
    }
    let problem = problem::problem(scene, problem::law(&scene.model)?).ok()?;
    of_problem(&problem, &problem::numerics(scene, None))
}

/// The same of a problem.
pub(super) fn of_problem(problem: &Problem, numerics: &Numerics) -> Option<Steady> {
    if problem.waveform.shape() != Shape::Sine {
        return None;
    }
    let ClosedForm { velocity_ratio, kappa, .. } =
        contact::closed_form(problem, numerics).filter(|form| form.velocity_ratio.is_finite())?;
    Some(Steady { velocity_ratio, kappa, coulomb_n: problem.coulomb_n })
}
