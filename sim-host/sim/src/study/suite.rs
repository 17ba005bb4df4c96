//! Run of a suite: its cases, targets and tables.

mod tables;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::{Limit, Study, StudyError};
use crate::bounds::Bounds;
use crate::instruments::View;
use crate::instruments::friction_switch::Step;
use crate::metrics::Metrics;
use contact::closed;
use report::statistics::ascending;
use scene::suite::{LoadedSuite, ReadyCase, Target};
use scene::{Scene, metrics, shown};

/// Function called with the name of each case that begins.
pub type Progress<'a> = &'a mut (dyn FnMut(&str) + Send);

/// Result of a suite.
pub struct SuiteResult<'a> {
    /// Suite that was run.
    pub suite: &'a LoadedSuite,
    /// Results of the cases, in order.
    pub cases: Vec<CaseResult<'a>>,
    /// Targets of the suite, each evaluated over all its cases.
    pub judged: Vec<TargetResult>,
}

/// Result of a case.
pub struct CaseResult<'a> {
    /// Case that was run.
    pub case: &'a ReadyCase,
    /// Metrics of each completed run.
    pub each: Vec<Metrics>,
    /// Metrics of all runs together.
    pub metrics: Metrics,
    /// Metrics that would be infinite.
    pub endless: Vec<&'static str>,
    /// Set points of the friction ratio, for a single run.
    pub steps: Vec<Step>,
    derived: Vec<(&'static str, Option<f64>)>,
}

/// A target, evaluated over its cases.
pub struct TargetResult {
    /// Metric of the target.
    pub metric: String,
    /// Limit, as text.
    pub limit: String,
    /// Number of cases.
    pub cases: usize,
    /// Case nearest to missing the target, or farthest beyond it, and its value.
    pub worst: Option<(String, Option<f64>)>,
    /// Cases that miss the target.
    pub missed: Vec<String>,
    /// Source of the target.
    pub source: String,
}

/// Runs every case of a suite, in parallel, until the caller sets `stop`.
///
/// # Errors
/// If a case has no result, or was stopped.
pub fn run<'a>(suite: &'a LoadedSuite, stop: Option<&AtomicBool>, progress: Progress) -> Result<SuiteResult<'a>, StudyError> {
    let progress = Mutex::new(progress);
    let one = |case: &'a ReadyCase| {
        if stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Err(StudyError::Interrupted);
        }
        progress.lock().unwrap_or_else(PoisonError::into_inner)(&case.name);
        let study = super::run(&case.loaded, super::Options { stop, ..super::Options::default() });
        let study = study.map_err(|error| StudyError::EmptyCell(format!("of the case `{}`", case.name), Box::new(error)))?;
        if study.interrupted { Err(StudyError::Interrupted) } else { Ok(CaseResult::read(case, study)) }
    };
    let cases = suite.cases.par_iter().map(one).collect::<Result<Vec<_>, StudyError>>()?;
    let judged = suite.suite.target.iter().map(|target| TargetResult::evaluate(target, &cases)).collect();
    Ok(SuiteResult { suite, cases, judged })
}

impl SuiteResult<'_> {
    /// Returns `true` if every target is met.
    pub fn holds(&self) -> bool {
        self.judged.iter().all(TargetResult::holds)
    }

    /// Returns a case by its name.
    pub fn case(&self, name: &str) -> Option<&CaseResult<'_>> {
        self.cases.iter().find(|case| case.case.name == name)
    }
}

impl<'a> CaseResult<'a> {
    fn read(case: &'a ReadyCase, study: Study) -> Self {
        let (each, endless) = match study.monte_carlo() {
            Some(runs) => (runs.runs.iter().map(|run| run.metrics.clone()).collect(), runs.endless.clone()),
            None => (vec![study.metrics.clone()], Vec::new()),
        };
        let steps = study.run().map_or_else(Vec::new, |run| View::new(&run.scene, &run.record).steps());
        let derived = derived(&case.loaded.scene, &study.metrics, &steps);
        CaseResult { case, each, endless, steps, derived, metrics: study.rest.metrics }
    }

    /// Returns a metric of all runs together, or a derived quantity; infinite if too many runs lack
    /// it.
    pub fn value(&self, metric: &str) -> Option<f64> {
        let derived = self.derived.iter().find(|(name, _)| *name == metric).and_then(|(_, value)| *value);
        let alone =
            || metrics::of_one_run(metric).filter(|_| self.each.len() == 1).and_then(|metric| self.metrics.find(metric.name));
        let endless = || self.endless.contains(&metric).then_some(f64::INFINITY);
        derived.or_else(|| self.metrics.find(metric)).or_else(alone).or_else(endless)
    }

    /// Returns the values of a metric over the runs, in ascending order.
    pub fn sorted(&self, metric: &str) -> Vec<f64> {
        ascending(self.each.iter().filter_map(|run| run.get(metric)))
    }
}

/// Returns the quantities listed in [`DERIVED`](scene::suite::DERIVED).
fn derived(scene: &Scene, metrics: &Metrics, steps: &[Step]) -> Vec<(&'static str, Option<f64>)> {
    let Some(scene) = scene.driven() else { return Vec::new() };
    let Bounds { times_ms: [to_20_hz, to_4_hz], ramp_hz } = Bounds::new(&scene);
    let tip_m_per_s = scene.controller.drive.velocity_m_per_s;
    let floor = scene.sliding().zip(tip_m_per_s).zip(metrics.get("kappa"));
    let error = |step: &Step| Some((step.estimate? - step.truth).abs());
    let held = || steps.iter().filter(|step| !step.is_refused());
    let any = |value: f64| (!steps.is_empty()).then_some(value);
    vec![
        ("bound_20hz_ms", to_20_hz),
        ("bound_4hz_ms", to_4_hz),
        ("bound_ramp_hz", ramp_hz),
        (
            "friction_floor",
            floor.map(|(((_, slider), tip_m_per_s), kappa)| closed::friction_ratio(slider.speed_m_per_s / tip_m_per_s, kappa)),
        ),
        ("friction_ratio_estimate_error", held().filter_map(error).reduce(f64::max)),
        ("friction_ratios", any(steps.len() as f64)),
        ("ratios_by_bursts", any(steps.iter().filter(|step| step.bursts).count() as f64)),
    ]
}

impl TargetResult {
    fn evaluate(target: &Target, cases: &[CaseResult]) -> Self {
        let listed = |case: &&CaseResult| {
            let ReadyCase { name, base, group, .. } = case.case;
            let by_name = target.cases.iter().any(|one| one == name || one == base);
            by_name || target.groups.contains(group) || (target.cases.is_empty() && target.groups.is_empty())
        };
        let of: Vec<&CaseResult> = cases.iter().filter(listed).collect();
        let limit = Limit::new((target.min, target.max), (target.value, target.tolerance));
        let one_of = |case: &CaseResult| {
            case.each.iter().find_map(|run| {
                Some(run.get(&target.metric)).filter(|value| !value.is_some_and(|value| target.one_of.contains(&value)))
            })
        };
        let (text, found): (String, Vec<(Option<f64>, f64)>) = if target.one_of.is_empty() {
            let beyond = |value: Option<f64>| value.map_or(f64::INFINITY, |value| limit.beyond(value));
            (limit.text.clone(), of.iter().map(|case| case.value(&target.metric)).map(|value| (value, beyond(value))).collect())
        } else {
            let values: Vec<String> = target.one_of.iter().map(|value| shown(*value)).collect();
            let other = |case: &&CaseResult| {
                one_of(case).map_or((case.sorted(&target.metric).first().copied(), -1.0), |value| (value, 1.0))
            };
            (format!("{} in each run", values.join(" or ")), of.iter().map(other).collect())
        };
        let name = |(case, _): &(&&CaseResult, &(Option<f64>, f64))| case.case.name.clone();
        let both = || of.iter().zip(&found);
        let worst = both().reduce(|a, b| if b.1.1 > a.1.1 { b } else { a }).map(|worst| (name(&worst), worst.1.0));
        TargetResult {
            metric: target.metric.clone(),
            limit: text,
            cases: of.len(),
            worst,
            missed: both().filter(|(_, (_, beyond))| *beyond > 0.0).map(|missed| name(&missed)).collect(),
            source: target.source.clone(),
        }
    }

    /// Returns `true` if every case meets the target.
    pub fn holds(&self) -> bool {
        self.missed.is_empty()
    }
}
