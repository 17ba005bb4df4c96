//! Vibration along the sliding: experiment 1 as its scenes run it, and Coulomb's law beside Dahl's.

use super::judged::{Prediction, list};
use crate::thesis::experiment_1::reductions;
use contact::SolveError;
use contact::closed::{coulomb_friction_ratio, friction_ratio};

/// A fall of the reduction by less than this is none that an experiment would show, points.
const LEAST_POINTS: f64 = 1.0;
/// Coulomb's law is adequate where it is within this part of the friction of Dahl's.
const ADEQUATE: f64 = 0.1;
/// Velocity ratio at which the laws are compared.
const VELOCITY_RATIO: f64 = 0.5;
/// Amplitudes of the vibration, in Dahl lengths: a small one, and one at which a contact is nearly Coulomb's.
const SMALL: f64 = 0.4;
const LARGE: f64 = 40.0;

/// Reductions over the loads of experiment 1, %.
pub struct Rail {
    /// Table 4.1's contact at 0.038 m/s.
    pub slow: Vec<f64>,
    /// The same at 0.068 m/s.
    pub fast: Vec<f64>,
    /// A stiffer contact on a slower tip, fitted.
    pub fitted: Vec<f64>,
}

impl Rail {
    /// Runs the scenes, controller and all.
    pub fn run() -> Result<Self, SolveError> {
        Ok(Rail {
            slow: reductions("experiment-1", &[])?,
            fast: reductions("experiment-1-fast", &[])?,
            fitted: reductions("experiment-1-fitted", &[])?,
        })
    }
}

/// Parameters of the scene, none of them from a friction that was measured.
const PLAIN: &str = "scene experiment-1: Table 4.1's contact, mu 0.3, tip velocity by the measured current";
const FITTED: &str = "scene experiment-1-fitted: Kt 2e6 N/m, half the tip velocity";
const TO: &[&str] = &["rail-68", "rail-load"];

/// Predictions of what experiment 1 states, and of the abstract on small amplitudes.
pub fn predictions(rail: &Rail) -> Vec<Prediction> {
    let falls =
        |reductions: &[f64]| reductions.first().zip(reductions.last()).is_some_and(|(none, most)| none - most > LEAST_POINTS);
    let load = |model: &str, values: &[f64]| {
        Prediction::sentence("rail-load", model, falls(values), format!("{} % at 0, 1, 2, 5, 10 N", list(values)))
    };
    let first = |reductions: &[f64]| reductions.first().copied().unwrap_or(f64::NAN);
    let (slow, fast) = (first(&rail.slow), first(&rail.fast));
    vec![
        Prediction::of("rail-68", PLAIN, slow),
        Prediction::of("rail-68", FITTED, first(&rail.fitted)).fitted_to(TO),
        Prediction::sentence("rail-speed", PLAIN, slow - fast > LEAST_POINTS, format!("{} %", list(&[slow, fast]))),
        load(PLAIN, &rail.slow),
        load(FITTED, &rail.fitted).fitted_to(TO),
        small_amplitude(),
    ]
}

fn small_amplitude() -> Prediction {
    let coulomb = coulomb_friction_ratio(VELOCITY_RATIO);
    let [small, large] = [SMALL, LARGE].map(|lengths| friction_ratio(VELOCITY_RATIO, lengths));
    let holds = (small - coulomb).abs() > ADEQUATE && (large - coulomb).abs() < ADEQUATE;
    let numbers = format!(
        "friction ratio at a velocity ratio of {VELOCITY_RATIO}: Coulomb {coulomb:.3}, Dahl {small:.3} at {SMALL} and {large:.3} at {LARGE} Dahl lengths"
    );
    Prediction::sentence("small-amplitude", "kinematic Dahl contact, closed form", holds, numbers)
}
