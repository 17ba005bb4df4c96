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
pub mod rows;
pub mod sensitivity;

#[cfg(test)]
mod tests;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use self::design::{Design, MOST_DRAWS, MOST_POINTS};
use self::rows::Measured;
pub use self::rows::Rows;
use super::abreast::{self, Mean};
use super::plan::{Cell, Made, Plan};
use super::{Options, StudyError, monte_carlo};
use crate::metrics::Metrics;
use scene::load::{LoadError, Loaded};
use scene::metrics::{self, METRICS, OF_RUNS};
use scene::nearest::{listed, nearest, short};
use scene::schema::{Kind, Schema};
use scene::shown;

/// The metric that has a column of its own in every row.
const FAULT_CODE: &str = "fault_code";
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
    #[error("`{metric}` {why}")]
    Metric {
        /// The metric.
        metric: String,
        /// Why not.
        why: String,
    },
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
        }
        if design.count() == 0 || design.count() > MOST_POINTS {
            return Err(SweepError::Points(design.count().into()));
        }
        let mut metrics = wanted(names, loaded.scene.runs > 1)?;
        metrics.retain(|&metric| metric != FAULT_CODE);
        let sweep = Sweep { loaded, metrics, all: names.is_empty(), design };
        let point = |point| sweep.loaded.cell(&sweep.sets(point)).map(drop);
        point(0).or_else(|error| point(sweep.design.count() - 1).map_err(|_| error))?;
        Ok(sweep)
    }

    /// What a point changes, as `key=value`. A number is written so that it is read back exactly.
    pub fn sets(&self, point: u64) -> Vec<String> {
        let value = |(key, value): (&str, f64)| format!("{key}={value:?}");
        self.design.keys().into_iter().zip(self.design.values(point)).map(value).collect()
    }

    /// The rows of some points, run in parallel; none if they are stopped. `done` is called after each point.
    pub fn rows(&self, points: Range<u64>, stop: &AtomicBool, done: &(dyn Fn() + Sync)) -> Result<Option<Rows>, StudyError> {
        let plan = Plan::new(self.loaded, stop)?;
        let means: Option<Vec<Mean>> = self.metrics.iter().map(|name| Mean::named(name)).collect();
        let one = |point: u64| {
            let run = (!plan.is_stopped()).then(|| self.point(&plan, point, means.as_deref()));
            done();
            run
        };
        let found: Vec<Option<Result<Measured, String>>> = points.clone().into_par_iter().map(one).collect();
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let mut rows = Rows::new(self.design.keys().len(), self.metrics.len());
        for (point, measured) in points.zip(found.into_iter().flatten()) {
            rows.push(point, &self.design.values(point), measured);
        }
        Ok(Some(rows))
    }

    /// Runs a point, or says why it has no result.
    fn point(&self, plan: &Plan, point: u64, means: Option<&[Mean]>) -> Result<Measured, String> {
        let sets = self.sets(point);
        let whole = |error: StudyError| format!("{:#}", anyhow::Error::from(error));
        if self.loaded.scene.runs > 1 {
            let changed = self.loaded.changed(&sets).map_err(|error| error.to_string())?;
            let (runs, metrics) = monte_carlo::run(&changed, Options::default(), plan.stop()).map_err(whole)?;
            let drive_hash = runs.drive_hash().map(|hash| format!("{hash:016x}"));
            return Ok(Measured { drive_hash, ..self.read(&metrics) });
        }
        let made = plan.make(Cell { label: sets.join(", "), sets }).map_err(|error| match error {
            StudyError::Cell(_, error) => error.to_string(),
            error => whole(error),
        })?;
        let excited = made.scene.excited();
        if let Some((steady, means)) = excited.as_ref().and_then(abreast::steady).zip(means) {
            // One by one, as what lanes give depends in its last bit on what is beside a point.
            let metrics = means.iter().map(|mean| mean.of(&[steady]).into_iter().next().flatten()).collect();
            return Ok(Measured { metrics, ..Measured::default() });
        }
        self.measured(&made).map_err(|error| match error {
            StudyError::EmptyCell(_, error) => whole(*error),
            error => whole(error),
        })
    }

    fn measured(&self, made: &Made) -> Result<Measured, StudyError> {
        match made.scene.driven() {
            Some(scene) => {
                let (record, metrics) = made.recorded(&scene)?;
                Ok(Measured { drive_hash: Some(format!("{:016x}", record.drive_hash)), ..self.read(&metrics) })
            }
            None => Ok(self.read(&made.metrics_for(Some(&self.metrics))?)),
        }
    }

    fn read(&self, metrics: &Metrics) -> Measured {
        let fault_code = metrics.get(FAULT_CODE).map(|code| code as i32);
        Measured { metrics: self.metrics.iter().map(|name| metrics.find(name)).collect(), drive_hash: None, fault_code }
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

/// The metrics of these names; all, without names.
fn wanted(names: &[String], several: bool) -> Result<Vec<&'static str>, SweepError> {
    let of_runs = OF_RUNS.iter().filter(|_| several).flat_map(|of| [of.p95.as_str(), of.max.as_str()]);
    let known: Vec<&'static str> = METRICS.iter().map(|metric| metric.name).chain(of_runs).collect();
    if names.is_empty() {
        return Ok(known);
    }
    let mut wanted = Vec::new();
    for name in names {
        let wrong = |why: String| SweepError::Metric { metric: short(name), why };
        let present = metrics::renamed(name).filter(|_| metrics::metric(name).is_none()).unwrap_or(name);
        let Some(&metric) = known.iter().find(|known| **known == present) else {
            let meant = nearest(name, known.iter().copied());
            return Err(wrong(match metrics::of_one_run(name) {
                Some(_) => "is of several runs, and the scene is run once: `--set runs=100`".to_owned(),
                None if meant.is_empty() => "is no metric; `sim-host explain` lists them".to_owned(),
                None => format!("is no metric; did you mean {}?", listed(meant.into_iter().take(3), "or")),
            }));
        };
        if wanted.contains(&metric) {
            return Err(wrong("is asked for twice".to_owned()));
        }
        wanted.push(metric);
    }
    Ok(wanted)
}
