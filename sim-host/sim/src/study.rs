//! A study: a scene, run; its metrics held against what was expected; and its grid and its comparison, if it has them.

pub mod across;
pub mod answer;
pub mod comparison;
pub mod contact;
mod detached;
pub mod driven;
pub mod grid;
pub mod in_plane;
pub mod matching;
pub mod monte_carlo;
mod plan;
pub mod playback;
mod points;
mod steady;
mod stopped;
pub mod suite;
pub mod sweep;

use std::sync::atomic::{AtomicBool, Ordering};

use self::comparison::ComparisonResult;
use self::contact::Solved;
pub use self::detached::Detached;
pub use self::driven::Level;
use self::driven::Run;
use self::grid::GridResult;
use self::monte_carlo::MonteCarlo;
use crate::metrics::Metrics;
use crate::overlay::{self, Overlaid};
use crate::processor::Processor;
use crate::run::RunError;
use ::contact::{Clock, SolveError};
use scene::load::{Inherited, LoadError, Loaded};
use scene::metrics;
use scene::{Driven, Equal, Expect, Kind, Scene, shown};

/// Why a study has no result.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The scene was not loaded, and lacks what loading would have asked for.
    #[error("the scene is neither a driven one nor a contact study")]
    Incomplete,
    /// The scene of a grid's cell, of a comparison's case or of one of several runs is invalid.
    #[error("the scene {0} is not valid")]
    Cell(String, #[source] LoadError),
    /// A grid's cell, a comparison's case or one of several runs has no result.
    #[error("the scene {0} has no result")]
    EmptyCell(String, #[source] Box<StudyError>),
    /// The run did not happen.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The contact study has no answer.
    #[error("the contact study has no answer")]
    Contact(#[from] SolveError),
    /// The scene's grid has no points.
    #[error("the scene's grid")]
    Grid(#[source] sweep::SweepError),
    /// The cases of a suite were stopped from outside.
    #[error("interrupted")]
    Interrupted,
}

/// The result of a study.
#[derive(Clone, Debug)]
pub struct Study<'a> {
    /// Name of the scene.
    pub name: String,
    /// Name, file or `<stdin>`, as a user calls the scene.
    pub origin: String,
    /// What was changed by hand, as `key=value`.
    pub changes: Vec<String>,
    /// Which of the scene's runs it is, if it is one of several.
    pub run_number: Option<u32>,
    /// The scene as it was run.
    pub scene: &'a Scene,
    /// Result of the scene, by its kind.
    pub outcome: Outcome<'a>,
    /// Metrics of the scene's run.
    pub metrics: Metrics,
    /// Expectations of the scene with their results.
    pub judged: Vec<Judged>,
    /// What the scene has of the one that it is laid over; nothing where it lies over none.
    pub inherited: Option<Inherited>,
    /// Results of the scene's grid.
    pub grid: Option<GridResult>,
    /// Results of the scene's comparison.
    pub comparison: Option<ComparisonResult>,
    /// The figures of the scene's run with the measured curves over them, where the scene has such.
    pub overlaid: Option<Overlaid>,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
}

/// Result of a scene, by its kind.
#[derive(Clone, Debug)]
pub enum Outcome<'a> {
    /// A run in which the firmware drove.
    Driven(Box<Run<'a>>),
    /// A contact was studied by itself.
    Contact(Box<Solved<'a>>),
    /// Many runs of either kind.
    MonteCarlo(Box<MonteCarlo>),
}

/// An expectation and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// Metric that is expected.
    pub metric: String,
    /// The case it is of, and what is equal there; none of the scene's own run.
    pub case: Option<(String, Equal)>,
    /// Value of the metric, if the run has one.
    pub value: Option<f64>,
    /// The limit, as text.
    pub limit: String,
    /// How far from a value it may be, if that is the limit.
    pub tolerance: Option<f64>,
    /// Whether it holds. A metric that the run does not have holds nothing.
    pub pass: bool,
    /// Whether it counts: not one of a base scene whose inputs were changed.
    pub counts: bool,
    /// Where the limit comes from.
    pub source: String,
}

impl Study<'_> {
    /// Whether every expectation that counts holds.
    pub fn passes(&self) -> bool {
        self.judged.iter().all(|judged| judged.pass || !judged.counts)
    }

    /// Whether every expectation holds, also those of a base scene whose inputs were changed.
    pub fn holds(&self) -> bool {
        self.judged.iter().all(|judged| judged.pass)
    }

    /// The driven run, if it was one.
    pub fn run(&self) -> Option<&Run<'_>> {
        match &self.outcome {
            Outcome::Driven(run) => Some(run),
            Outcome::Contact(_) | Outcome::MonteCarlo(_) => None,
        }
    }

    /// The runs, if there were many.
    pub fn monte_carlo(&self) -> Option<&MonteCarlo> {
        match &self.outcome {
            Outcome::MonteCarlo(runs) => Some(runs),
            Outcome::Driven(_) | Outcome::Contact(_) => None,
        }
    }
}

/// A processor other than this process for the controllers of a study: each run of a scene has one of its own.
#[derive(Clone, Copy)]
pub struct Start<'a> {
    /// What it is.
    pub level: Level,
    /// Starts one for a scene.
    pub processor: &'a Starting<'a>,
}

/// Starts a processor for a scene.
pub type Starting<'a> = dyn Fn(&Driven) -> Result<Box<dyn Processor>, RunError> + Sync + 'a;

/// What a study is given from outside. By default nothing: controllers run in this process, to the end, untimed.
#[derive(Default)]
pub struct Options<'a> {
    /// Starts the processors of the scene's own runs; without it their controllers run in this process, as those of cells always do.
    pub start: Option<Start<'a>>,
    /// Set from outside to stop the study.
    pub stop: Option<&'a AtomicBool>,
    /// Called with the simulated time, s, or of several runs with how many have come to their end.
    pub progress: Option<&'a mut (dyn FnMut(f64) + Send)>,
    /// Times the scene's own runs. Wall times are none of a study's results without it.
    pub clock: Option<Clock>,
}

/// What a value is held against.
pub(crate) struct Limit {
    min: Option<f64>,
    max: Option<f64>,
    /// The limit in words.
    pub(crate) text: String,
}

impl Limit {
    /// From a least and a largest value, or from a value and how far from it another may be.
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

    /// How far a value is beyond the limit; not above zero where it holds.
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
            let cut = runs.runs.len() < scene.runs as usize;
            let figures = || monte_carlo::figures::of(scene, &runs);
            let overlaid = (!scene.overlay.is_empty()).then(|| overlay::lay(figures(), &scene.overlay, None));
            (Outcome::MonteCarlo(Box::new(runs)), metrics, overlaid, cut, None)
        }
        Kind::Driven(scene) => {
            // One run is one thread: the cells of grid and comparison have the others meanwhile.
            let Options { start, progress, clock, .. } = options;
            let run = || driven::run(scene, (start, clock), stop, progress.map(|progress| progress as &mut dyn FnMut(f64)));
            let (run, cells) = rayon::join(run, || cells(loaded, stop));
            let (run, metrics, overlaid) = run?;
            let cut = run.record.interrupted;
            (Outcome::Driven(Box::new(run)), metrics, overlaid, cut, Some(cells?))
        }
        Kind::Excited(scene) => {
            let progress = options.progress.as_mut().map(|progress| progress as &mut dyn FnMut(f64));
            let (solved, metrics, overlaid) = contact::run(scene, options.clock, stop, progress)?;
            let cut = solved.answer.is_none();
            (Outcome::Contact(Box::new(solved)), metrics, overlaid, cut, None)
        }
    };
    let (grid, comparison) = match cells {
        _ if cut => (None, None),
        Some(cells) => cells,
        None => self::cells(loaded, stop)?,
    };
    // How many runs come out in some way is nothing that one run has.
    let has = |expect: &&Expect| scene.runs > 1 || !expect.metric.starts_with("runs_");
    // One of several runs is what its scene says of all of them.
    let inherited = loaded.inherited().filter(|_| loaded.run.is_none());
    let counts = !inherited.as_ref().is_some_and(|inherited| inherited.expect);
    let judged = |expect| Judged { counts, ..judge(expect, &metrics, comparison.as_ref()) };
    let judged = scene.expect.iter().filter(has).map(judged).collect();
    // Stopped within the grid or the comparison: the scene is whole, and they are missing.
    let interrupted = cut || stop.load(Ordering::Relaxed);
    let (name, origin, changes) = (loaded.name.clone(), loaded.origin.clone(), loaded.sets.clone());
    let run_number = loaded.run;
    Ok(Study {
        name,
        origin,
        changes,
        run_number,
        scene,
        outcome,
        metrics,
        judged,
        inherited,
        grid,
        comparison,
        overlaid,
        interrupted,
    })
}

/// The results of a scene's grid and of its comparison, as far as it has them.
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
        // Of one run, percentile and maximum of a metric are the metric.
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
