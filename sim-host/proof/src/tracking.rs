//! The tracker, measured: every case over many runs, beside what it was to reach and what nothing can undercut; and every defect of a
//! transducer or its wiring, with the fault that comes of it.
//!
//! ```text
//! cases (scene + changes + targets) --> Monte Carlo --+--> tables: docs/tracking.md, report
//! bounds (Cramer-Rao of the same scene) --------------+
//! bad input (scene + defect) --> fault and time ------+
//! ```
//!
//! All of it is simulated (SIL). Each case is a scene of its own: [`Case::command`] says how to run it.

pub mod bad_input;
pub mod cases;
pub mod table;

#[cfg(test)]
mod tests;

use std::sync::atomic::AtomicBool;

use self::bad_input::Defect;
use self::cases::{CASES, Case, Family, Target};
use scene::load::LoadError;
use sim::bounds::Bounds;
use sim::metrics::Metrics;
use sim::study::monte_carlo::MonteCarlo;
use sim::study::{self, StudyError};

/// How much is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Runs of each case.
    pub runs: u32,
    /// Runs of each case in which anything may happen.
    pub runs_of_anything: u32,
    /// Runs of each defect.
    pub runs_of_a_defect: u32,
}

impl Extent {
    /// What the documentation states.
    pub const FULL: Self = Extent { runs: 200, runs_of_anything: 1000, runs_of_a_defect: 12 };
    /// Enough to see that nothing has become worse.
    pub const QUICK: Self = Extent { runs: 40, runs_of_anything: 40, runs_of_a_defect: 2 };

    fn of(self, family: Family) -> u32 {
        if family == Family::Anything { self.runs_of_anything } else { self.runs }
    }
}

/// A case that has been run.
pub struct Found {
    /// Which.
    pub case: &'static Case,
    /// Its runs.
    pub runs: MonteCarlo,
    /// Their numbers.
    pub metrics: Metrics,
    /// What nothing can undercut.
    pub bounds: Bounds,
}

/// A target, judged.
pub struct Judged {
    /// What was to be reached.
    pub target: &'static Target,
    /// What was; infinite if some runs never reach it.
    pub found: f64,
}

impl Judged {
    /// Whether it was reached.
    pub fn holds(&self) -> bool {
        self.found <= self.target.at_most
    }
}

impl Found {
    /// Its targets, judged.
    pub fn judged(&self) -> impl Iterator<Item = Judged> + '_ {
        self.case.targets.iter().map(|target| Judged { target, found: self.value(target.metric) })
    }

    /// A number of its runs, without its sign; infinite if it has none.
    pub fn value(&self, metric: &str) -> f64 {
        self.metrics.get(metric).map_or(f64::INFINITY, f64::abs)
    }

    /// Runs with a false lock, with an undetected loss, and that ended in a fault.
    pub fn flaws(&self) -> [f64; 3] {
        ["false_locks", "undetected_losses", "runs_faulted"].map(|metric| self.metrics.get(metric).unwrap_or_default())
    }
}

/// Everything that was run.
pub struct Campaign {
    /// The cases.
    pub found: Vec<Found>,
    /// The defects.
    pub defects: Vec<Defect>,
}

impl Campaign {
    /// Whether every target is reached, nothing is called locked that is not, and each defect ends as it is stated to.
    pub fn holds(&self) -> bool {
        let case = |found: &Found| found.judged().all(|judged| judged.holds()) && found.flaws()[..2] == [0.0; 2];
        self.found.iter().all(case) && self.defects.iter().all(Defect::holds)
    }
}

/// Why there is no campaign.
#[derive(Debug, thiserror::Error)]
pub enum Trouble {
    /// A scene is not valid.
    #[error("the case `{0}`: {1}")]
    Scene(String, LoadError),
    /// A scene has no result.
    #[error("the case `{0}` has no result")]
    Empty(String, #[source] StudyError),
}

/// Runs everything; `progress` is told what comes next.
pub fn conduct(extent: Extent, progress: &mut dyn FnMut(&str)) -> Result<Campaign, Trouble> {
    let mut next = |case: &'static Case| {
        progress(case.name);
        one(case, extent.of(case.family))
    };
    let found = CASES.iter().map(&mut next).collect::<Result<Vec<_>, _>>()?;
    progress("bad input");
    Ok(Campaign { found, defects: bad_input::conduct(extent.runs_of_a_defect)? })
}

/// Runs one case so often.
pub fn one(case: &'static Case, runs: u32) -> Result<Found, Trouble> {
    let loaded = case.load(runs).map_err(|error| Trouble::Scene(case.name.to_owned(), error))?;
    let bounds = loaded.scene.driven().map_or_else(Bounds::default, |scene| Bounds::of(&scene));
    let study = study::conduct(&loaded, None, &AtomicBool::new(false), None);
    let study = study.map_err(|error| Trouble::Empty(case.name.to_owned(), error))?;
    let runs = study.monte_carlo().cloned().unwrap_or_else(MonteCarlo::none);
    Ok(Found { case, runs, metrics: study.metrics, bounds })
}
