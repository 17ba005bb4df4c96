//! Vibration along the sliding: experiment 1 as in its scenes, and Coulomb's law compared with
//! Dahl's.

use super::judged::{Prediction, list};
use crate::thesis::experiment_1::reductions;
use contact::SolveError;
use contact::closed::{coulomb_friction_ratio, friction_ratio};

/// Smallest decrease of the reduction that an experiment would show, percentage points.
const MIN_FALL_POINTS: f64 = 1.0;
/// Largest deviation from Dahl's friction at which Coulomb's law counts as adequate, relative.
const ADEQUATE_REL: f64 = 0.1;
/// Velocity ratio at which the laws are compared.
const VELOCITY_RATIO: f64 = 0.5;
/// Small vibration amplitude, Dahl lengths.
const SMALL_DAHL_LENGTHS: f64 = 0.4;
/// Vibration amplitude at which a contact follows Coulomb's law closely, Dahl lengths.
const LARGE_DAHL_LENGTHS: f64 = 40.0;

/// Reductions at the loads of experiment 1, %.
pub struct Rail {
    /// Contact of Table 4.1 at 0.038 m/s.
    pub slow: Vec<f64>,
    /// Contact of Table 4.1 at 0.068 m/s.
    pub fast: Vec<f64>,
    /// Stiffer contact on a slower tip, fitted.
    pub fitted: Vec<f64>,
}

impl Rail {
    /// Runs the scenes, including the controller.
    pub fn run() -> Result<Self, SolveError> {
        Ok(Rail {
            slow: reductions("experiment-1", &[])?,
            fast: reductions("experiment-1-fast", &[])?,
            fitted: reductions("experiment-1-fitted", &[])?,
        })
    }
}

/// Parameters of the scene, none of them from a measured friction.
const PLAIN_MODEL: &str = "scene experiment-1: Table 4.1's contact, mu 0.3, tip velocity from the measured current";
const FITTED_MODEL: &str = "scene experiment-1-fitted: Kt 2e6 N/m, half the tip velocity";
const FITTED_DATA: &[&str] = &["rail-68", "rail-load"];

/// Returns the predictions for the statements of experiment 1 and for the abstract on small
/// amplitudes.
pub fn predictions(rail: &Rail) -> Vec<Prediction> {
    let falls =
        |reductions: &[f64]| reductions.first().zip(reductions.last()).is_some_and(|(none, most)| none - most > MIN_FALL_POINTS);
    let load = |model: &str, values: &[f64]| {
        Prediction::sentence("rail-load", model, falls(values), format!("{} % at 0, 1, 2, 5, 10 N", list(values)))
    };
    let first = |reductions: &[f64]| reductions.first().copied().unwrap_or(f64::NAN);
    let (slow, fast) = (first(&rail.slow), first(&rail.fast));
    vec![
        Prediction::number("rail-68", PLAIN_MODEL, slow),
        Prediction::number("rail-68", FITTED_MODEL, first(&rail.fitted)).fitted_to(FITTED_DATA),
        Prediction::sentence("rail-speed", PLAIN_MODEL, slow - fast > MIN_FALL_POINTS, format!("{} %", list(&[slow, fast]))),
        load(PLAIN_MODEL, &rail.slow),
        load(FITTED_MODEL, &rail.fitted).fitted_to(FITTED_DATA),
        small_amplitude(),
    ]
}

fn small_amplitude() -> Prediction {
    let coulomb = coulomb_friction_ratio(VELOCITY_RATIO);
    let [small, large] = [SMALL_DAHL_LENGTHS, LARGE_DAHL_LENGTHS].map(|lengths| friction_ratio(VELOCITY_RATIO, lengths));
    let holds = (small - coulomb).abs() > ADEQUATE_REL && (large - coulomb).abs() < ADEQUATE_REL;
    let numbers = format!(
        "friction ratio at a velocity ratio of {VELOCITY_RATIO}: Coulomb {coulomb:.3}, Dahl {small:.3} at {SMALL_DAHL_LENGTHS} and \
         {large:.3} at {LARGE_DAHL_LENGTHS} Dahl lengths"
    );
    Prediction::sentence("small-amplitude", "kinematic Dahl contact, closed form", holds, numbers)
}
