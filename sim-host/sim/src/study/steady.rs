//! Contact studies with a closed form: the means of a steady sine follow from two numbers.

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
    /// Returns the metric of this name, if it is one of these.
    pub(super) fn named(metric: &str) -> Option<Self> {
        Some(match metric {
            "friction_ratio" => Mean::FrictionRatio,
            "reduction_percent" => Mean::ReductionPercent,
            "friction_on_n" => Mean::FrictionOnN,
            "power_ratio" => Mean::PowerRatio,
            _ => return None,
        })
    }

    /// Returns the metric of a study, as in [`metrics`](crate::study::contact::metrics); `None` if
    /// the study has no power ratio.
    pub(super) fn value(self, study: &Steady) -> Option<f64> {
        let Steady { velocity_ratio, kappa, .. } = *study;
        let ratio = || closed::friction_ratio(velocity_ratio, kappa);
        match self {
            Mean::FrictionRatio => Some(ratio()),
            Mean::ReductionPercent => Some(100.0 * (1.0 - ratio())),
            Mean::FrictionOnN => Some(ratio() * study.coulomb_n),
            // The reference Fc Vt is negative if the sliding is.
            Mean::PowerRatio => Some(closed::power_ratio(velocity_ratio, kappa)? * velocity_ratio.signum()),
        }
    }
}

/// Returns the steady sine of a scene that is solved by its closed form; `None` for any other
/// scene.
pub(super) fn from_scene(scene: &Excited) -> Option<Steady> {
    if problem::direction(scene).is_some() {
        return None;
    }
    let problem = problem::problem(scene, problem::law(&scene.model)?).ok()?;
    from_problem(&problem, &problem::numerics(scene, None))
}

/// Returns the steady sine of a problem that is solved by its closed form.
pub(super) fn from_problem(problem: &Problem, numerics: &Numerics) -> Option<Steady> {
    if problem.waveform.shape() != Shape::Sine {
        return None;
    }
    let ClosedForm { velocity_ratio, kappa, .. } =
        contact::closed_form(problem, numerics).filter(|form| form.velocity_ratio.is_finite())?;
    Some(Steady { velocity_ratio, kappa, coulomb_n: problem.coulomb_n })
}
