//! The friction switch, measured: ratios over contacts, by amplitude and by bursts, three ways each: command, estimate, truth.
//!
//! ```text
//! cases (scene + changes) --> one run each, a ratio after the other --> tables: docs/friction.md, report
//! closed form (contact::closed) --> floors, and what the survey should find
//! ```
//!
//! All of it is simulated (SIL). Each case is a scene of its own: [`Case::command`] says how to run it.

pub mod cases;
pub mod plot;
pub mod table;

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use self::cases::Case;
use scene::load::LoadError;
use sim::instruments::friction_switch::Step;
use sim::instruments::{View, measure};
use sim::metrics::Metrics;
use sim::run::{RunError, Watch, run};

/// How far a ratio may be off.
pub const TOLERANCE: f64 = 0.02;

/// A case that has been run.
pub struct Found {
    /// Which.
    pub case: Case,
    /// Its ratios.
    pub steps: Vec<Step>,
    /// Its other numbers.
    pub metrics: Metrics,
}

impl Found {
    /// The largest error of a ratio that is not refused.
    pub fn worst(&self) -> f64 {
        self.steps.iter().filter(|step| !step.is_refused()).map(|step| step.error().abs()).fold(0.0, f64::max)
    }

    /// Whether all that is wanted has been had, and what cannot be has been refused.
    pub fn holds(&self) -> bool {
        let refused = |step: &Step| step.is_refused() == (step.wanted < self.case.floor() - 0.01);
        self.steps.len() == self.case.wanted().len() && self.worst() <= TOLERANCE && self.steps.iter().all(refused)
    }
}

/// Why there is no campaign.
#[derive(Debug, thiserror::Error)]
pub enum Trouble {
    /// A scene is not valid.
    #[error("the case `{0}`: {1}")]
    Scene(String, LoadError),
    /// A scene has not been run.
    #[error("the case `{0}` has not been run")]
    Run(String, #[source] RunError),
}

/// Runs some cases, all at once.
pub fn conduct(cases: Vec<Case>) -> Result<Vec<Found>, Trouble> {
    cases.into_par_iter().map(one).collect()
}

fn one(case: Case) -> Result<Found, Trouble> {
    let loaded = case.load().map_err(|error| Trouble::Scene(case.name(), error))?;
    let Some(scene) = loaded.scene.driven() else { return Ok(Found { case, steps: Vec::new(), metrics: Metrics::default() }) };
    let record = run(&scene, Watch::default()).map_err(|error| Trouble::Run(case.name(), error))?;
    Ok(Found { case, steps: View::new(&scene, &record).steps(), metrics: measure(&scene, &record) })
}
