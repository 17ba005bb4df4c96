//! Result of a study as JSON: the output of `--format json`, `summary.json` and `machine.json`.

mod comparison;
mod grid;

use serde_json::{Value, json};

use crate::study::answer::Answer;
use crate::study::design;
use crate::study::monte_carlo::uncertainty::{self, Shares};
use crate::study::{Outcome, Study};
use crate::tables;

/// Returns the output of `--format json`: the summary, and the machine figures.
pub fn printed(study: &Study) -> Value {
    let mut printed = summary(study);
    printed["machine"] = machine(study);
    printed
}

/// Returns the machine figures, as in `machine.json`: everything that differs from run to run.
pub fn machine(study: &Study) -> Value {
    let (wall_s, speed, ns) = match &study.outcome {
        Outcome::Driven(run) => (run.record.wall_s, run.record.simulated_s_per_wall_s(), None),
        Outcome::Contact(solved) => (None, None, solved.answer.as_ref().and_then(|answer| answer.solution.ns_per_period)),
        Outcome::Design(_) => (None, None, None),
        Outcome::MonteCarlo(runs) => {
            let speed = runs.wall_s.map(|wall_s| runs.runs.len() as f64 * study.scene.duration_s / wall_s);
            (runs.wall_s, speed, None)
        }
    };
    let processors = std::thread::available_parallelism().map(std::num::NonZero::get).ok();
    let figures = [
        ("wall_s", wall_s.map(Value::from)),
        ("simulated_s_per_wall_s", speed.map(Value::from)),
        ("ns_per_period", ns.map(Value::from)),
        ("processors", processors.map(Value::from)),
        ("system", Some(format!("{} {}", std::env::consts::OS, std::env::consts::ARCH).into())),
    ];
    figures.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect::<serde_json::Map<_, _>>().into()
}

/// Returns the summary, as in `summary.json`. It is identical, byte for byte, for every run of the
/// same scene.
pub fn summary(study: &Study) -> Value {
    let endless = study.monte_carlo().into_iter().flat_map(|runs| &runs.endless).map(|&name| (name.to_owned(), Value::Null));
    let metrics: serde_json::Map<String, Value> =
        study.metrics.iter().map(|(name, value)| (name.to_owned(), json!(value))).chain(endless).collect();
    let expect: Vec<Value> = study
        .judged
        .iter()
        .map(|judged| {
            let mut expect = json!({
                "metric": judged.metric, "value": judged.value, "limit": judged.limit,
                "pass": judged.pass, "source": judged.source,
            });
            if !judged.counts {
                expect["counts"] = json!(false);
            }
            if let Some((case, equal)) = &judged.case {
                (expect["case"], expect["match"]) = (json!(case), json!(equal));
            }
            expect
        })
        .collect();
    let grid = study.grid.as_ref().map(grid::json);
    let comparison = study.comparison.as_ref().map(comparison::json);
    let summary = json!({
        "scene": study.name, "seed": study.scene.seed, "metrics": metrics, "expect": expect, "grid": grid,
        "comparison": comparison, "interrupted": study.interrupted,
    });
    with_own(with_provisos(summary, study), study)
}

/// Adds the measured curves that are not shown, and the values that the user did not set, if there
/// are any.
pub(crate) fn with_provisos(mut of: Value, study: &Study) -> Value {
    let not_drawn = tables::not_drawn(study);
    if !not_drawn.is_empty() {
        of["overlays_not_drawn"] = json!(not_drawn);
    }
    if !study.assumed.is_empty() {
        of["assumed"] = json!(study.assumed);
    }
    of
}

/// Adds the fields of this kind of study: the hash of the drive codes, or the description
/// of the solution.
pub(crate) fn with_own(mut of: Value, study: &Study) -> Value {
    match &study.outcome {
        Outcome::Driven(run) => of["drive_hash"] = json!(format!("{:016x}", run.record.drive_hash)),
        Outcome::MonteCarlo(runs) => {
            of["runs"] = json!(runs.runs.len());
            if let Some(interval) = uncertainty::intervals(study.scene, runs).first()
                && let Some(Shares { keys, rest }) = uncertainty::shares(study.scene, runs, interval.line.1)
            {
                let keys: Vec<Value> = keys.iter().map(|(keys, part)| json!({ "keys": keys, "part": part })).collect();
                of["variance"] = json!({ "metric": interval.line.1, "keys": keys, "rest": rest });
            }
            of["drive_hash"] = json!(runs.drive_hash().map(|hash| format!("{hash:016x}")));
        }
        Outcome::Design(drawn) => of["design"] = design::json(drawn),
        Outcome::Contact(solved) => {
            of["solution"] = json!(solved.answer.as_ref().map(|Answer { solution, .. }| {
                let mut how = json!({
                    "method": solution.method.name(), "why": solution.why, "order": solution.order,
                    "steps_per_period": solution.steps_per_period, "error_estimate": solution.error_estimate,
                    "tolerance_met": solution.tolerance_met,
                    "warnings": solution.warnings,
                });
                if let Some(error) = solution.record_error_estimate {
                    how["record_error_estimate"] = json!(error);
                }
                how
            }));
        }
    }
    of
}
