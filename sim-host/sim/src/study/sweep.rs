//! A sweep: metrics of a scene at many points, each the scene with some keys set.
//!
//! ```text
//! axes, or a list --> design --> points (number -> values) --> scenes, run in parallel --> rows (point, values, metrics, or why not)
//! ```
//!
//! A row follows from the scene and the point alone, so that neither the number of threads nor how the points are divided changes it. Every
//! point has the scene's own seed: points differ by their keys, and not by their noise. A scene of several `runs` has the statistics of
//! its runs at each point. A point whose scene is not valid, or that has no result, is a row as well, with the reason.

pub mod axis;
pub mod design;
pub mod figures;
pub mod rows;
pub mod sensitivity;

#[cfg(test)]
mod tests;

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use self::design::{Design, MOST_DRAWS, MOST_POINTS};
use self::rows::Measured;
pub use self::rows::Rows;
use super::contact::laid_in_closed_form;
use super::plan::{Cell, Made, Plan};
use super::points::{BESIDE, Points};
use super::{Options, StudyError, monte_carlo};
use crate::instruments;
use crate::metrics::Metrics;
pub use crate::overlay::is_metric as is_of_overlays;
use crate::run::LANES;
use scene::load::{LoadError, Loaded};
use scene::metrics::{self, OF_RUNS};
use scene::nearest::{nearest, short};
use scene::replaced::Replaced;
use scene::schema::{Kind, Schema, last_name, unit_of};
use scene::{Scene, shown};

/// The metric that has a column of its own in every row.
const FAULT_CODE: &str = "fault_code";
/// Points, less one, that stand for all where what they show is asked before any work.
const LOOKED_AT: u64 = 15;
/// What is no number of a cell.
const NOT_OF_A_POINT: [&str; 6] = ["seed", "runs", "vary", "grid", "comparison", "expect"];

/// Why there is no sweep.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// An axis cannot be read.
    #[error("`{text}` is no axis: {why} (for example `contact.dahl.mu=0.1:0.4:7`)")]
    Axis {
        /// As it was written.
        text: String,
        /// What is wrong.
        why: String,
    },
    /// A kind of sample that there is not.
    #[error("`{0}` is no sample: write `sobol:N`, with the number of pairs of draws, as `sobol:1024`")]
    Sample(String),
    /// A file of points cannot be opened.
    #[error("cannot read the points `{file}`: {io}")]
    Open {
        /// The file.
        file: String,
        /// Why.
        #[source]
        io: std::io::Error,
    },
    /// A file of points cannot be read.
    #[error("{file}, line {line}: {why}")]
    File {
        /// The file.
        file: String,
        /// The line, from 1.
        line: u64,
        /// What is wrong.
        why: String,
    },
    /// A key is there twice.
    #[error("the key `{0}` is there twice")]
    Twice(String),
    /// Nothing says which points.
    #[error("no points: give `--over key=start:stop:n` for each key, a `--sample` of ranges, or `--points FILE`")]
    None,
    /// No points, or too many.
    #[error("{0} points: a sweep has from 1 to {MOST_POINTS}")]
    Points(u128),
    /// A sample of no keys, or of too many.
    #[error("a sample of {0} keys: it has from 1 to 128, each given as `--over key=least:most`")]
    Sampled(usize),
    /// A sample of too few draws, or of too many.
    #[error("a sample of {0} draws: it has from 2 to {MOST_DRAWS}, and for indices a power of two is best")]
    Draws(u64),
    /// A key is no number of a scene.
    #[error("`{key}` {why}")]
    Key {
        /// The key.
        key: String,
        /// Why not.
        why: String,
    },
    /// A metric is not known, or not of such a scene.
    #[error("{0}")]
    Metric(String),
    /// Neither the first nor the last point makes a scene.
    #[error("neither the first nor the last point is a valid scene")]
    Scene(#[from] LoadError),
}

/// Metrics of a scene at many points.
#[derive(Clone, Debug)]
pub struct Sweep<'a> {
    /// The scene that the points change.
    pub loaded: &'a Loaded,
    /// The points.
    pub design: Design,
    /// The metrics of each, in the order they were asked for, but the fault code, which every row has.
    pub metrics: Vec<&'static str>,
    /// Whether all metrics were asked for, rather than some by name.
    pub all: bool,
}

impl<'a> Sweep<'a> {
    /// A sweep of a scene. Without names it has all metrics.
    ///
    /// # Errors
    /// If a key is no number of a scene or leaves its range, a metric is not known, or neither the first nor the last point is a valid scene.
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
        let sweep = Sweep { loaded, metrics, all: names.is_empty(), design };
        let made = if loaded.scene.runs > 1 { Loaded::changed } else { Loaded::cell };
        let point = |point| made(loaded, &sweep.sets(point)).map(drop);
        point(0).or_else(|error| point(sweep.design.count() - 1).map_err(|_| error))?;
        // Each of several runs draws numbers of its own.
        held.filter(|_| loaded.scene.runs == 1).map_or(Ok(()), |metric| sweep.check_closed(metric))?;
        Ok(sweep)
    }

    /// A measured curve that no point in closed form shows is refused before any work: it is beside their one period, or none of their curves. Some points
    /// stand for all of them; where one of these takes steps, or has the metric, nothing is refused.
    fn check_closed(&self, metric: &str) -> Result<(), SweepError> {
        let last = self.design.count() - 1;
        let some = (0..=LOOKED_AT).map(|place| (u128::from(last) * u128::from(place) / u128::from(LOOKED_AT)) as u64);
        let mut why = None;
        for point in some {
            let Ok(cell) = self.loaded.cell(&self.sets(point)) else { continue };
            let laid = cell.scene.excited().and_then(|scene| laid_in_closed_form(&scene));
            let Some((_, laid)) = laid.filter(|(metrics, _)| metrics.find(metric).is_none()) else { return Ok(()) };
            why.get_or_insert_with(|| laid.not_drawn.join(" "));
        }
        let Some(why) = why else { return Ok(()) };
        let why = if why.is_empty() {
            "the measured curves are of other units, or of none of its curves over time.".to_owned()
        } else {
            why
        };
        Err(SweepError::Metric(format!("no point has `{metric}`: {why}")))
    }

    /// What a point changes, as `key=value`. A number is written so that it is read back exactly.
    pub fn sets(&self, point: u64) -> Vec<String> {
        let value = |(key, value): (&str, f64)| format!("{key}={value:?}");
        self.design.keys().into_iter().zip(self.design.values(point)).map(value).collect()
    }

    /// The rows of some points, run in parallel; none if they are stopped. `done` is called after each point.
    pub fn rows(&self, points: Range<u64>, stop: &AtomicBool, done: &(dyn Fn() + Sync)) -> Result<Option<Rows>, StudyError> {
        let plan = Plan::new(self.loaded, stop)?;
        let points: Vec<u64> = points.collect();
        let (keys, threads) = (self.design.keys(), rayon::current_num_threads());
        let contacts = |first: u64| Points::new(&plan, self.cell(first), &keys, &self.metrics);
        let way = match (self.loaded.scene.runs, self.loaded.scene.controller.is_some(), points.first()) {
            (1, false, Some(&first)) => Way::Contacts(Box::new(contacts(first))),
            (1, ..) => Way::Driven,
            _ => Way::Runs,
        };
        let beside = match way {
            Way::Contacts(_) => points.len().div_ceil(4 * threads).clamp(8, BESIDE),
            // A run waits for those beside it: with few points more is gained by sharing them out one by one.
            Way::Driven => (points.len() / (4 * threads)).clamp(1, LANES),
            // Its own runs go side by side.
            Way::Runs => 1,
        };
        let of_group = |group: &[u64]| {
            if plan.is_stopped() {
                return None;
            }
            let measured = match &way {
                Way::Contacts(contacts) => self.contacts(contacts, group)?,
                Way::Driven => self.driven(&plan, group),
                Way::Runs => group.iter().map(|&point| self.runs(&plan, point)).collect(),
            };
            group.iter().for_each(|_| done());
            Some(measured)
        };
        let found: Option<Vec<Vec<Result<Measured, String>>>> = points.par_chunks(beside).map(of_group).collect();
        let Some(found) = found.filter(|_| !plan.is_stopped()) else { return Ok(None) };
        let mut rows = Rows::new(keys.len(), self.metrics.len());
        for (point, measured) in points.into_iter().zip(found.into_iter().flatten()) {
            rows.push(point, &self.design.values(point), measured);
        }
        Ok(Some(rows))
    }

    /// A point as a scene of its own.
    fn cell(&self, point: u64) -> Cell {
        let sets = self.sets(point);
        Cell { label: sets.join(", "), sets }
    }

    /// Contact studies, solved beside each other.
    fn contacts(&self, contacts: &Points, group: &[u64]) -> Option<Vec<Result<Measured, String>>> {
        let found = contacts.metrics(group, |&point| self.design.values(point), |&point| self.cell(point))?;
        let measured = |metrics| Measured { metrics, ..Measured::default() };
        Some(found.into_iter().map(|found| found.map(measured).map_err(why)).collect())
    }

    /// Runs of the controller, side by side.
    fn driven(&self, plan: &Plan, group: &[u64]) -> Vec<Result<Measured, String>> {
        let made: Vec<Result<Made, String>> = group.iter().map(|&point| plan.make(self.cell(point)).map_err(why)).collect();
        let mut records = Made::abreast(&made.iter().flatten().collect::<Vec<_>>()).into_iter();
        let measured = |made: Result<Made, String>| {
            let (made, record) = (made?, records.next().unwrap_or(Ok(None)).map_err(why)?);
            let Some((scene, record)) = made.scene.driven().zip(record) else { return Err(why(StudyError::Incomplete)) };
            let drive_hash = Some(format!("{:016x}", record.drive_hash));
            Ok(Measured { drive_hash, ..self.read(&instruments::measure(&scene, &record)) })
        };
        made.into_iter().map(measured).collect()
    }

    /// The statistics of a scene of several runs.
    fn runs(&self, plan: &Plan, point: u64) -> Result<Measured, String> {
        let changed = self.loaded.changed(&self.sets(point)).map_err(|error| error.to_string())?;
        let (runs, metrics) = monte_carlo::run(&changed, Options::default(), plan.stop()).map_err(why)?;
        let drive_hash = runs.drive_hash().map(|hash| format!("{hash:016x}"));
        Ok(Measured { drive_hash, ..self.read(&metrics) })
    }

    fn read(&self, metrics: &Metrics) -> Measured {
        let fault_code = metrics.get(FAULT_CODE).map(|code| code as i32);
        Measured { metrics: self.metrics.iter().map(|name| metrics.find(name)).collect(), drive_hash: None, fault_code }
    }
}

/// How the points of a sweep are run.
enum Way<'p, 'a> {
    /// As contact studies, solved beside each other.
    Contacts(Box<Points<'p, 'a>>),
    /// As runs of the controller, side by side.
    Driven,
    /// As several runs each.
    Runs,
}

/// Why a point has no result, with every cause; the point itself is named beside it.
fn why(error: StudyError) -> String {
    match error {
        StudyError::Cell(_, error) => error.to_string(),
        StudyError::EmptyCell(_, error) => why(*error),
        error => format!("{:#}", anyhow::Error::from(error)),
    }
}

/// A key must be a number of a scene, and its values such as that number may have.
fn check_key(key: &str, (least, most): (f64, f64), sampled: bool) -> Result<(), SweepError> {
    let wrong = |why: String| Err(SweepError::Key { key: short(key), why });
    let Some(schema) = Schema::root().at(key).filter(|schema| schema.is_number()) else {
        let numbers = Schema::numbers();
        return wrong(match nearest(key, numbers.iter().map(String::as_str)).first() {
            Some(meant) => format!("is no number of a scene; did you mean `{meant}`?"),
            None => "is no number of a scene: tables and key, with points between, as `contact.dahl.mu` (`sim-host show SCENE`)"
                .to_owned(),
        });
    };
    if NOT_OF_A_POINT.contains(&key.split('.').next().unwrap_or(key)) {
        return wrong("is the same at every point: sweep a number of the plant, the contact or the controller".to_owned());
    }
    let (low, high) = schema.range();
    let below =
        low.filter(|&low| least < low).map(|low| format!("must be at least {}, and goes down to {}", shown(low), shown(least)));
    let above =
        high.filter(|&high| most > high).map(|high| format!("must be at most {}, and goes up to {}", shown(high), shown(most)));
    if let Some(out) = below.or(above) {
        return wrong(out);
    }
    if schema.kind() == Kind::Integer && sampled {
        return wrong("is a whole number, and a sample takes any number of its range: give its values with `--over`".to_owned());
    }
    if schema.kind() == Kind::Integer && (least.fract() != 0.0 || most.fract() != 0.0) {
        return wrong("is a whole number".to_owned());
    }
    Ok(())
}

/// Refuses a key that another part of the scene replaces before it has an effect.
fn check_effect(key: &str, scene: &Scene, keys: &[&str]) -> Result<(), SweepError> {
    let Some(Replaced { why, help, .. }) = scene.replaced(key, keys) else { return Ok(()) };
    Err(SweepError::Key { key: key.to_owned(), why: format!("{why}, and other values change nothing: {help}") })
}

/// A metric of measured curves needs such a curve.
fn check_overlays(metric: &str, scene: &Scene) -> Result<(), SweepError> {
    if scene.overlay.is_empty() {
        return Err(SweepError::Metric(format!("`{metric}` is of a scene with [[overlay]], and this one has none")));
    }
    Ok(())
}

/// The metrics of these names; all, without names.
fn wanted(names: &[String], several: bool) -> Result<Vec<&'static str>, SweepError> {
    let mut wanted = Vec::new();
    for name in names {
        let wrong = |why: String| SweepError::Metric(why);
        let metric = metrics::known(name).map_err(wrong)?;
        if !several && metrics::of_one_run(metric).is_some() {
            return Err(wrong(format!("`{metric}` is of several runs, and the scene is run once: `--set runs=100`")));
        }
        if wanted.contains(&metric) {
            return Err(wrong(format!("`{metric}` is asked for twice")));
        }
        wanted.push(metric);
    }
    if wanted.is_empty() {
        let of_runs = OF_RUNS.iter().filter(|_| several).flat_map(|of| [of.p95.as_str(), of.max.as_str()]);
        wanted.extend(metrics::names().chain(of_runs));
    }
    Ok(wanted)
}

/// The unit of a key or metric; `1` of a ratio or a count.
pub fn unit(name: &str) -> String {
    let metric = metrics::metric(name).or_else(|| metrics::of_one_run(name)).map(|metric| metric.unit.to_owned());
    metric.or_else(|| unit_of(last_name(name))).unwrap_or_else(|| "1".to_owned())
}
