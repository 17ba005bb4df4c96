//! A sweep: metrics of a scene at many points, each the scene with some keys set.
//!
//! ```text
//! axes, or a list --> design --> points (number -> values) --> scenes, run in parallel --> rows (point, values, metrics or reason)
//! ```
//!
//! A row depends only on the scene and the point, not on the number of threads or the division into
//! shards. Every point has the scene's own seed: points differ by their keys, not by their noise. A
//! scene with several `runs` has the statistics of its runs at each point. A point whose scene is
//! invalid, or that has no result, has a row with the reason.

pub mod axis;
pub mod design;
pub mod figures;
pub mod rows;
pub mod sensitivity;

#[cfg(test)]
mod tests;

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use self::design::{Design, MOST_DRAWS, MOST_POINTS};
use self::rows::PointResult;
pub use self::rows::Rows;
use super::contact::overlaid_closed_form;
use super::plan::{Cell, Made, Plan};
use super::points::{MAX_BATCH, Points};
use super::{Options, StudyError, monte_carlo};
use crate::instruments;
use crate::metrics::Metrics;
pub use crate::overlay::is_metric as is_of_overlays;
use crate::run::LANES;
use scene::load::{LoadError, Loaded};
use scene::metrics::{self, OF_RUNS, OfRuns};
use scene::nearest::{nearest, short};
use scene::replaced::Replaced;
use scene::schema::{Kind, Schema, last_name, unit_of};
use scene::{Scene, shown};

/// Metric with its own column in every row.
const FAULT_CODE: &str = "fault_code";
/// Number of points, minus one, that are examined before any work, as a sample of all.
const EXAMINED_POINTS: u64 = 15;
/// Tables and keys of a scene that are not numbers of a cell.
const FIXED_KEYS: [&str; 6] = ["seed", "runs", "vary", "grid", "comparison", "expect"];

/// Reason that there is no sweep.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// An axis cannot be read.
    #[error("`{text}` is not an axis: {why} (for example `contact.dahl.mu=0.1:0.4:7`)")]
    Axis {
        /// Text as written.
        text: String,
        /// Reason.
        why: String,
    },
    /// The kind of sample is unknown.
    #[error("`{0}` is not a sample: write `sobol:N` with the number of pairs of draws, for example `sobol:1024`")]
    Sample(String),
    /// A file of points cannot be opened.
    #[error("cannot read the points `{file}`: {io}")]
    Open {
        /// File.
        file: String,
        /// Reason.
        #[source]
        io: std::io::Error,
    },
    /// A file of points cannot be read.
    #[error("{file}, line {line}: {why}")]
    File {
        /// File.
        file: String,
        /// Line number, from 1.
        line: u64,
        /// Reason.
        why: String,
    },
    /// A key occurs twice.
    #[error("the key `{0}` occurs twice")]
    Twice(String),
    /// No points are given.
    #[error("no points: give `--over key=start:stop:n` for each key, a `--sample` over ranges, or `--points FILE`")]
    None,
    /// The number of points is zero or too large.
    #[error("{0} points: a sweep has from 1 to {MOST_POINTS}")]
    Points(u128),
    /// The number of keys of a sample is zero or too large.
    #[error("a sample of {0} keys: it has from 1 to 128, each given as `--over key=least:most`")]
    Sampled(usize),
    /// The number of draws of a sample is too small or too large.
    #[error("a sample of {0} draws: it has from 2 to {MOST_DRAWS}; for indices, use a power of two")]
    Draws(u64),
    /// A key is not a number of a scene.
    #[error("`{key}` {why}")]
    Key {
        /// Key.
        key: String,
        /// Reason.
        why: String,
    },
    /// A metric is unknown, or does not apply to the scene.
    #[error("{0}")]
    Metric(String),
    /// Neither the first nor the last point is a valid scene.
    #[error("neither the first nor the last point is a valid scene")]
    Scene(#[from] LoadError),
}

/// Metrics of a scene at many points.
#[derive(Clone, Debug)]
pub struct Sweep<'a> {
    /// The scene that the points change.
    pub loaded: &'a Loaded,
    /// Points of the sweep.
    pub design: Design,
    /// Metrics of each point, in the requested order, without the fault code, which every row has.
    pub metrics: Vec<&'static str>,
    /// `true` if all metrics were requested, not some by name.
    pub all: bool,
    /// Number of computed points whose means are over a window, because no steady state was found.
    unsettled: Arc<AtomicU64>,
}

impl<'a> Sweep<'a> {
    /// Creates a sweep of a scene; without names it has all metrics.
    ///
    /// # Errors
    /// If a key is not a number of a scene or leaves its range, if a metric is unknown, or if
    /// neither the first nor the last point is a valid scene.
    pub fn new(loaded: &'a Loaded, design: Design, names: &[String]) -> Result<Self, SweepError> {
        for (place, key) in design.keys().into_iter().enumerate() {
            check_key(key, design.ends(place), matches!(design, Design::Sample { .. }))?;
            check_effect(key, &loaded.scene, &design.keys())?;
        }
        if design.count() == 0 || design.count() > MOST_POINTS {
            return Err(SweepError::Points(design.count().into()));
        }
        let mut metrics = wanted(names, loaded.scene.runs > 1)?;
        let held = metrics.iter().copied().find(|metric| !names.is_empty() && is_of_overlays(metric));
        if let Some(metric) = held {
            check_overlays(metric, &loaded.scene)?;
        }
        metrics.retain(|&metric| metric != FAULT_CODE);
        let sweep = Sweep { loaded, metrics, all: names.is_empty(), design, unsettled: Arc::default() };
        let made = if loaded.scene.runs > 1 { Loaded::changed } else { Loaded::cell };
        let point = |point| made(loaded, &sweep.sets(point)).map(drop);
        point(0).or_else(|error| point(sweep.design.count() - 1).map_err(|_| error))?;
        // Each of several runs draws its own numbers.
        held.filter(|_| loaded.scene.runs == 1).map_or(Ok(()), |metric| sweep.check_closed(metric))?;
        Ok(sweep)
    }

    /// Refuses, before any work, a measured curve that no closed-form point can show: it is outside
    /// their one period, or matches none of their curves. Some points are examined; if one of them
    /// takes steps or has the metric, nothing is refused.
    fn check_closed(&self, metric: &str) -> Result<(), SweepError> {
        let last = self.design.count() - 1;
        let some = (0..=EXAMINED_POINTS).map(|place| (u128::from(last) * u128::from(place) / u128::from(EXAMINED_POINTS)) as u64);
        let mut why = None;
        for point in some {
            let Ok(cell) = self.loaded.cell(&self.sets(point)) else { continue };
            let laid = cell.scene.excited().and_then(|scene| overlaid_closed_form(&scene));
            let Some((_, laid)) = laid.filter(|(metrics, _)| metrics.find(metric).is_none()) else { return Ok(()) };
            why.get_or_insert_with(|| laid.not_drawn.join(" "));
        }
        let Some(why) = why else { return Ok(()) };
        let why = if why.is_empty() {
            "the measured curves have other units, or match none of its curves over time.".to_owned()
        } else {
            why
        };
        Err(SweepError::Metric(format!("no point has `{metric}`: {why}")))
    }

    /// Returns the changes of a point, as `key=value`. Numbers are written so that they are read
    /// back exactly.
    pub fn sets(&self, point: u64) -> Vec<String> {
        let value = |(key, value): (&str, f64)| format!("{key}={value:?}");
        self.design.keys().into_iter().zip(self.design.values(point)).map(value).collect()
    }

    /// Computes the rows of some points in parallel; `None` if stopped. `done` is called after each
    /// point.
    pub fn rows(&self, points: Range<u64>, stop: &AtomicBool, done: &(dyn Fn() + Sync)) -> Result<Option<Rows>, StudyError> {
        let plan = Plan::new(self.loaded, stop)?;
        let points: Vec<u64> = points.collect();
        let (keys, threads) = (self.design.keys(), rayon::current_num_threads());
        let contacts = |first: u64| Points::new(&plan, self.cell(first), (&keys, &self.metrics), &self.unsettled);
        let method = match (self.loaded.scene.runs, self.loaded.scene.controller.is_some(), points.first()) {
            (1, false, Some(&first)) => PointMethod::Contacts(Box::new(contacts(first))),
            (1, ..) => PointMethod::Driven,
            _ => PointMethod::Runs,
        };
        let batch = match method {
            PointMethod::Contacts(_) => points.len().div_ceil(4 * threads).clamp(8, MAX_BATCH),
            // A run waits for the others in its batch; with few points, single runs finish sooner.
            PointMethod::Driven => (points.len() / (4 * threads)).clamp(1, LANES),
            // The runs of a point are batched themselves.
            PointMethod::Runs => 1,
        };
        let of_group = |group: &[u64]| {
            if plan.is_stopped() {
                return None;
            }
            let measured = match &method {
                PointMethod::Contacts(contacts) => self.contacts(contacts, group)?,
                PointMethod::Driven => self.driven(&plan, group),
                PointMethod::Runs => group.iter().map(|&point| self.runs(&plan, point)).collect(),
            };
            group.iter().for_each(|_| done());
            Some(measured)
        };
        let found: Option<Vec<Vec<Result<PointResult, String>>>> = points.par_chunks(batch).map(of_group).collect();
        let Some(found) = found.filter(|_| !plan.is_stopped()) else { return Ok(None) };
        let mut rows = Rows::new(keys.len(), self.metrics.len());
        for (point, measured) in points.into_iter().zip(found.into_iter().flatten()) {
            rows.push(point, &self.design.values(point), measured);
        }
        Ok(Some(rows))
    }

    /// Returns the number of points computed so far whose means are over the last periods of a run,
    /// because no steady state was found.
    pub fn unsettled(&self) -> u64 {
        self.unsettled.load(Ordering::Relaxed)
    }

    /// Returns the cell of a point.
    fn cell(&self, point: u64) -> Cell {
        let sets = self.sets(point);
        Cell { label: sets.join(", "), sets }
    }

    /// Solves contact studies in a batch.
    fn contacts(&self, contacts: &Points, group: &[u64]) -> Option<Vec<Result<PointResult, String>>> {
        let found = contacts.metrics(group, |&point| self.design.values(point), |&point| self.cell(point))?;
        let measured = |metrics| PointResult { metrics, ..PointResult::default() };
        Some(found.into_iter().map(|found| found.map(measured).map_err(why)).collect())
    }

    /// Runs the controller at several points in a batch.
    fn driven(&self, plan: &Plan, group: &[u64]) -> Vec<Result<PointResult, String>> {
        let made: Vec<Result<Made, String>> = group.iter().map(|&point| plan.make(self.cell(point)).map_err(why)).collect();
        let mut records = Made::run_batch(&made.iter().flatten().collect::<Vec<_>>()).into_iter();
        let measured = |made: Result<Made, String>| {
            let (made, record) = (made?, records.next().unwrap_or(Ok(None)).map_err(why)?);
            let Some((scene, record)) = made.scene.driven().zip(record) else { return Err(why(StudyError::Incomplete)) };
            let drive_hash = Some(format!("{:016x}", record.drive_hash));
            Ok(PointResult { drive_hash, ..self.read(&instruments::measure(&scene, &record)) })
        };
        made.into_iter().map(measured).collect()
    }

    /// Computes the statistics of a scene with several runs.
    fn runs(&self, plan: &Plan, point: u64) -> Result<PointResult, String> {
        let changed = self.loaded.changed(&self.sets(point)).map_err(|error| error.to_string())?;
        // As many at each point: a jump of the number would be a jump of the metrics.
        let changed = Loaded { default_runs: false, ..changed };
        let (runs, metrics) = monte_carlo::run(&changed, Options::default(), plan.stop()).map_err(why)?;
        let drive_hash = runs.drive_hash().map(|hash| format!("{hash:016x}"));
        Ok(PointResult { drive_hash, ..self.read(&metrics) })
    }

    fn read(&self, metrics: &Metrics) -> PointResult {
        let fault_code = metrics.get(FAULT_CODE).map(|code| code as i32);
        PointResult { metrics: self.metrics.iter().map(|name| metrics.find(name)).collect(), drive_hash: None, fault_code }
    }
}

/// Method of running the points of a sweep.
enum PointMethod<'p, 'a> {
    /// Contact studies, solved in batches.
    Contacts(Box<Points<'p, 'a>>),
    /// Runs of the controller, in batches.
    Driven,
    /// Several runs per point.
    Runs,
}

/// Returns the reason that a point has no result, with every cause but without the point itself.
fn why(error: StudyError) -> String {
    match error {
        StudyError::Cell(_, error) => error.to_string(),
        StudyError::EmptyCell(_, error) => why(*error),
        error => format!("{:#}", anyhow::Error::from(error)),
    }
}

/// Checks that a key is a number of a scene, and that its values are in range.
fn check_key(key: &str, (least, most): (f64, f64), sampled: bool) -> Result<(), SweepError> {
    let wrong = |why: String| Err(SweepError::Key { key: short(key), why });
    let Some(schema) = Schema::root().at(key).filter(|schema| schema.is_number()) else {
        let numbers = Schema::numbers();
        return wrong(match nearest(key, numbers.iter().map(String::as_str)).first() {
            Some(meant) => format!("is not a number of a scene; did you mean `{meant}`?"),
            None => "is not a number of a scene: join tables and key with dots, for example `contact.dahl.mu` (`sim-host show \
                     SCENE`)"
                .to_owned(),
        });
    };
    if FIXED_KEYS.contains(&key.split('.').next().unwrap_or(key)) {
        return wrong("must be the same at every point: sweep a number of the plant, the contact or the controller".to_owned());
    }
    let (low, high) = schema.range();
    let below =
        low.filter(|&low| least < low).map(|low| format!("must be at least {}, but goes down to {}", shown(low), shown(least)));
    let above =
        high.filter(|&high| most > high).map(|high| format!("must be at most {}, but goes up to {}", shown(high), shown(most)));
    if let Some(out) = below.or(above) {
        return wrong(out);
    }
    if schema.kind() == Kind::Integer && sampled {
        return wrong("is a whole number, but a sample takes any number of its range: give its values with `--over`".to_owned());
    }
    if schema.kind() == Kind::Integer && (least.fract() != 0.0 || most.fract() != 0.0) {
        return wrong("must be a whole number".to_owned());
    }
    Ok(())
}

/// Refuses a key that another part of the scene replaces before it has an effect.
fn check_effect(key: &str, scene: &Scene, keys: &[&str]) -> Result<(), SweepError> {
    let Some(Replaced { why, help, .. }) = scene.replaced(key, keys) else { return Ok(()) };
    Err(SweepError::Key { key: key.to_owned(), why: format!("{why}, so other values have no effect: {help}") })
}

/// Checks that a scene has the measured curve that a metric requires.
fn check_overlays(metric: &str, scene: &Scene) -> Result<(), SweepError> {
    if scene.overlay.is_empty() {
        return Err(SweepError::Metric(format!("`{metric}` requires a scene with [[overlay]], which this scene lacks")));
    }
    Ok(())
}

/// Returns the metrics of these names; without names, all.
fn wanted(names: &[String], several: bool) -> Result<Vec<&'static str>, SweepError> {
    let mut wanted = Vec::new();
    for name in names {
        let wrong = |why: String| SweepError::Metric(why);
        let metric = metrics::known(name).map_err(wrong)?;
        if !several && metrics::of_one_run(metric).is_some() {
            return Err(wrong(format!("`{metric}` requires several runs, but the scene runs once: `--set runs=100`")));
        }
        if wanted.contains(&metric) {
            return Err(wrong(format!("`{metric}` is requested twice")));
        }
        wanted.push(metric);
    }
    if wanted.is_empty() {
        let of_runs = OF_RUNS.iter().filter(|_| several).flat_map(OfRuns::names);
        wanted.extend(metrics::names().chain(of_runs));
    }
    Ok(wanted)
}

/// Returns the unit of a key or metric; `1` for a ratio or a count.
pub fn unit(name: &str) -> String {
    let metric = metrics::metric(name).or_else(|| metrics::of_one_run(name)).map(|metric| metric.unit.to_owned());
    metric.or_else(|| unit_of(last_name(name))).unwrap_or_else(|| "1".to_owned())
}
