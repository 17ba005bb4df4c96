//! A study: the run of a scene, its expectations and, if it has them, its grid and its comparison.

pub mod across;
pub mod answer;
pub mod comparison;
pub mod contact;
pub mod design;
mod detached;
pub mod driven;
pub mod grid;
pub mod in_plane;
pub mod matching;
pub mod monte_carlo;
pub mod optimise;
mod plan;
pub mod playback;
mod points;
pub mod solve;
mod steady;
mod stopped;
pub mod suite;
pub mod sweep;

use std::ops::Deref;
use std::sync::atomic::{AtomicBool, Ordering};

use self::comparison::ComparisonResult;
use self::contact::Solved;
use self::design::Drawn;
pub use self::detached::Detached;
pub use self::driven::Level;
use self::driven::Run;
use self::grid::GridResult;
use self::monte_carlo::MonteCarlo;
use crate::metrics::Metrics;
use crate::overlay::{self, Overlaid};
use crate::processor::Processor;
use crate::run::RunError;
use ::contact::custom::FrictionLaw;
use ::contact::{Clock, SolveError};
use scene::load::{Assumed, Inherited, LoadError, Loaded};
use scene::metrics;
use scene::{Driven, Equal, Expect, Kind, Scene, shown};

/// Reason that a study has no result.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The scene was not loaded, and lacks parts that loading would have required.
    #[error("the scene is neither a driven one, nor a contact study, nor a design")]
    Incomplete,
    /// The scene of a grid cell, of a comparison's case or of one of several runs is invalid.
    #[error("the scene {0} is not valid")]
    Cell(String, #[source] LoadError),
    /// A grid cell, a comparison's case or one of several runs has no result.
    #[error("the scene {0} has no result")]
    EmptyCell(String, #[source] Box<StudyError>),
    /// The run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The design has no solution.
    #[error("the design has no solution")]
    Design(#[from] ::design::DesignError),
    /// The contact study has no solution.
    #[error("the contact study has no solution")]
    Contact(#[from] SolveError),
    /// The scene's grid is invalid.
    #[error("the scene's grid is not valid")]
    Grid(#[source] sweep::SweepError),
    /// The cases of a suite were stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

/// Result of a study.
#[derive(Clone, Debug)]
pub struct Study<'a> {
    /// Scene as it was run.
    pub scene: &'a Scene,
    /// Result of the scene, by its kind.
    pub outcome: Outcome<'a>,
    /// Everything that does not borrow the scene.
    pub rest: Rest,
}

/// Everything of a study that does not borrow its scene.
#[derive(Clone, Debug)]
pub struct Rest {
    /// Name of the scene.
    pub name: String,
    /// Name, file or `<stdin>`, as given by the user.
    pub origin: String,
    /// Changes by `--set`, as `key=value`.
    pub changes: Vec<String>,
    /// Number of the run, if it is one of several.
    pub run_number: Option<u32>,
    /// Metrics of the scene's run.
    pub metrics: Metrics,
    /// Expectations of the scene with their results.
    pub judged: Vec<Judged>,
    /// Parts that the scene inherits from its base; `None` without a base.
    pub inherited: Option<Inherited>,
    /// Values that the user did not set for this transducer or contact.
    pub assumed: Vec<Assumed>,
    /// Results of the scene's grid.
    pub grid: Option<GridResult>,
    /// Results of the scene's comparison.
    pub comparison: Option<ComparisonResult>,
    /// Figures of the scene's run with measured curves, if the scene has any.
    pub overlaid: Option<Overlaid>,
    /// `true` if the study was stopped before its end.
    pub interrupted: bool,
}

impl Deref for Study<'_> {
    type Target = Rest;

    fn deref(&self) -> &Rest {
        &self.rest
    }
}

/// Result of a scene, by its kind.
#[derive(Clone, Debug)]
pub enum Outcome<'a> {
    /// A run driven by the firmware.
    Driven(Box<Run<'a>>),
    /// A study of a contact alone.
    Contact(Box<Solved<'a>>),
    /// The design of a transducer or horn.
    Design(Box<Drawn<'a>>),
    /// Several runs of either kind.
    MonteCarlo(Box<MonteCarlo>),
}

/// An expectation and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// Expected metric.
    pub metric: String,
    /// Case of a comparison and its matched quantity; `None` for the scene's own run.
    pub case: Option<(String, Equal)>,
    /// Value of the metric, if the run has one.
    pub value: Option<f64>,
    /// Limit, as text.
    pub limit: String,
    /// Tolerance about a value, if that is the limit.
    pub tolerance: Option<f64>,
    /// `true` if the expectation is met; `false` if the run lacks the metric.
    pub pass: bool,
    /// `true` if the expectation counts: `false` for one of a base scene whose inputs were changed.
    pub counts: bool,
    /// Source of the limit.
    pub source: String,
}

impl Study<'_> {
    /// Returns `true` if every expectation that counts is met.
    pub fn passes(&self) -> bool {
        self.judged.iter().all(|judged| judged.pass || !judged.counts)
    }

    /// Returns `true` if every expectation is met, including those of a base scene whose inputs
    /// were changed.
    pub fn holds(&self) -> bool {
        self.judged.iter().all(|judged| judged.pass)
    }

    /// Returns the driven run, if there is one.
    pub fn run(&self) -> Option<&Run<'_>> {
        match &self.outcome {
            Outcome::Driven(run) => Some(run),
            Outcome::Contact(_) | Outcome::Design(_) | Outcome::MonteCarlo(_) => None,
        }
    }

    /// Returns the design, if the scene is one.
    pub fn design(&self) -> Option<&Drawn<'_>> {
        match &self.outcome {
            Outcome::Design(drawn) => Some(drawn),
            Outcome::Driven(_) | Outcome::Contact(_) | Outcome::MonteCarlo(_) => None,
        }
    }

    /// Returns the runs, if there are several.
    pub fn monte_carlo(&self) -> Option<&MonteCarlo> {
        match &self.outcome {
            Outcome::MonteCarlo(runs) => Some(runs),
            Outcome::Driven(_) | Outcome::Contact(_) | Outcome::Design(_) => None,
        }
    }
}

/// Source of processors other than this process for the controllers of a study: each run of a scene
/// has its own.
#[derive(Clone, Copy)]
pub struct Start<'a> {
    /// Level of the processor.
    pub level: Level,
    /// Function that starts one for a scene.
    pub processor: &'a Starting<'a>,
}

/// Function that starts a processor for a scene.
pub type Starting<'a> = dyn Fn(&Driven) -> Result<Box<dyn Processor>, RunError> + Sync + 'a;

/// Options of a study. By default, controllers run in this process, to the end, untimed.
#[derive(Default)]
pub struct Options<'a> {
    /// Source of processors for the scene's own runs. Without it, their controllers run in this
    /// process, as those of cells always do.
    pub start: Option<Start<'a>>,
    /// Flag that the caller sets to stop the study.
    pub stop: Option<&'a AtomicBool>,
    /// Function called with the simulated time, s, or for several runs, with the number of
    /// completed ones.
    pub progress: Option<&'a mut (dyn FnMut(f64) + Send)>,
    /// Clock that times the scene's own runs. Without it, the results contain no wall times.
    pub clock: Option<Clock>,
    /// Friction law of the caller, which replaces the contact's in the run of a contact study; its
    /// grid and its comparison keep the contact's.
    pub law: Option<&'a (dyn FrictionLaw + Sync)>,
}

/// Limit of a value.
pub(crate) struct Limit {
    min: Option<f64>,
    max: Option<f64>,
    /// Limit in words.
    pub(crate) text: String,
}

impl Limit {
    /// Creates a limit from a minimum and a maximum, or from a value and its tolerance.
    fn new((min, max): (Option<f64>, Option<f64>), value: (Option<f64>, Option<f64>)) -> Self {
        if let (Some(value), Some(tolerance)) = value {
            let text = format!("{} ± {}", shown(value), shown(tolerance));
            return Limit { min: Some(value - tolerance), max: Some(value + tolerance), text };
        }
        let text = match (min, max) {
            (Some(min), Some(max)) => format!("{} to {}", shown(min), shown(max)),
            (Some(min), None) => format!("at least {}", shown(min)),
            (None, Some(max)) => format!("at most {}", shown(max)),
            (None, None) => "anything".into(),
        };
        Limit { min, max, text }
    }

    /// Returns the distance of a value beyond the limit; not above zero if the limit is met.
    fn beyond(&self, value: f64) -> f64 {
        let below = self.min.map_or(f64::NEG_INFINITY, |min| min - value);
        let above = self.max.map_or(f64::NEG_INFINITY, |max| value - max);
        if value.is_nan() { f64::INFINITY } else { below.max(above) }
    }
}

/// Runs a loaded scene, its grid and its comparison.
///
/// # Errors
/// If a scene of it cannot be built or run.
pub fn run<'a>(loaded: &'a Loaded, mut options: Options) -> Result<Study<'a>, StudyError> {
    let scene = &loaded.scene;
    let never = AtomicBool::new(false);
    let stop = options.stop.unwrap_or(&never);
    let (outcome, metrics, overlaid, cut, cells) = match scene.kind().ok_or(StudyError::Incomplete)? {
        _ if scene.runs > 1 => {
            let (runs, metrics) = monte_carlo::run(loaded, options, stop)?;
            let cut = runs.runs.len() < runs.asked as usize;
            let figures = || monte_carlo::figures::all(scene, &runs);
            let overlaid = (!scene.overlay.is_empty()).then(|| overlay::lay(figures(), &scene.overlay, None));
            (Outcome::MonteCarlo(Box::new(runs)), metrics, overlaid, cut, None)
        }
        Kind::Driven(scene) => {
            // A single run takes one thread; the cells of grid and comparison use the others
            // meanwhile.
            let Options { start, progress, clock, .. } = options;
            let run = || driven::run(scene, (start, clock), stop, progress.map(|progress| progress as &mut dyn FnMut(f64)));
            let (run, cells) = rayon::join(run, || cells(loaded, stop));
            let (run, metrics, overlaid) = run?;
            let cut = run.record.interrupted;
            (Outcome::Driven(Box::new(run)), metrics, overlaid, cut, Some(cells?))
        }
        Kind::Excited(scene) => {
            let progress = options.progress.as_mut().map(|progress| progress as &mut dyn FnMut(f64));
            let (solved, metrics, overlaid) = contact::run(scene, (options.clock, options.law), stop, progress)?;
            let cut = solved.answer.is_none();
            (Outcome::Contact(Box::new(solved)), metrics, overlaid, cut, None)
        }
        Kind::Designed(scene) => {
            let drawn = Drawn::new(scene)?;
            let metrics = design::measure(&drawn);
            (Outcome::Design(Box::new(drawn)), metrics, None, false, None)
        }
    };
    let (grid, comparison) = match cells {
        _ if cut => (None, None),
        Some(cells) => cells,
        None => self::cells(loaded, stop)?,
    };
    // A single run has no metrics that count runs.
    let has = |expect: &&Expect| scene.runs > 1 || !expect.metric.starts_with("runs_");
    // One of several runs is not judged as inherited: its scene defines all of them.
    let inherited = loaded.inherited().filter(|_| loaded.run.is_none());
    let counts = !inherited.as_ref().is_some_and(|inherited| inherited.expect);
    let judged = |expect| Judged { counts, ..judge(expect, &metrics, comparison.as_ref()) };
    let judged = scene.expect.iter().filter(has).map(judged).collect();
    // If stopped within the grid or the comparison, the run is complete, and they are missing.
    let interrupted = cut || stop.load(Ordering::Relaxed);
    let rest = Rest {
        name: loaded.name.clone(),
        origin: loaded.origin.clone(),
        changes: loaded.sets.clone(),
        run_number: loaded.run,
        metrics,
        judged,
        inherited,
        assumed: loaded.assumed.clone(),
        grid,
        comparison,
        overlaid,
        interrupted,
    };
    Ok(Study { scene, outcome, rest })
}

/// Returns the results of a scene's grid and of its comparison, if it has them.
fn cells(loaded: &Loaded, stop: &AtomicBool) -> Result<(Option<GridResult>, Option<ComparisonResult>), StudyError> {
    let grid = loaded.scene.grid.as_ref().map(|grid| grid::run(loaded, grid, stop)).transpose()?;
    let comparison = loaded.scene.comparison.as_ref().map(|comparison| comparison::run(loaded, comparison, stop)).transpose()?;
    Ok((grid.flatten(), comparison.flatten()))
}

fn judge(expect: &Expect, metrics: &Metrics, comparison: Option<&ComparisonResult>) -> Judged {
    let limit = Limit::new((expect.min, expect.max), (expect.value, expect.tolerance));
    let case = expect.case.clone().zip(expect.matched);
    let value = match &case {
        Some((name, equal)) => comparison.and_then(|found| found.case(name, *equal)?.metric(&expect.metric)),
        // For a single run, percentile and maximum of a metric equal the metric.
        None => metrics.find(&expect.metric).or_else(|| {
            let once = metrics.get("runs_completed").is_none();
            metrics::of_one_run(&expect.metric).filter(|_| once).and_then(|metric| metrics.find(metric.name))
        }),
    };
    Judged {
        metric: expect.metric.clone(),
        case,
        value,
        tolerance: expect.tolerance,
        pass: value.is_some_and(|value| limit.beyond(value) <= 0.0),
        counts: true,
        limit: limit.text,
        source: expect.source.clone(),
    }
}
