//! Output of a measurement: the numbers as CSV and JSON, the curves, and the report.

use serde_json::{Value, json};

use super::claims::Target;
use super::sample::Errors;
use super::study::Study;
use super::{plots, table};
use crate::campaign::{cells, csv};
use crate::evidence::Error;
use report::Report;

/// Returns every point of every curve, as CSV.
pub fn work(study: &Study) -> Result<String, Error> {
    let points = study.curves.iter().flat_map(|curve| curve.points.iter().map(move |point| (curve.method.name, point)));
    let rows = points.map(|(method, point)| {
        let Errors { force, mean, displacement } = point.errors;
        let instructions = point.instructions.map(|count| count.to_string()).unwrap_or_default();
        let [force, mean, displacement] = [force, mean, displacement].map(|error| format!("{error:e}"));
        cells![method, point.steps, point.ns, instructions, force, mean, displacement]
    });
    csv("method,steps_per_period,ns_per_period,instructions_per_period,error_f,error_mean,error_x", rows)
}

/// Builds the report of the study.
pub fn page(study: &Study) -> Report {
    Report {
        title: "Precision: speed against error".into(),
        subtitle: "Every method on one standard case, the claims, and the hard cases".into(),
        tables: vec![table::claims(&study.claims), table::reference(&study.reference), table::hard(&study.hard)],
        figures: plots::figures(study),
        appendix: vec![table::work(study)],
        footer: vec![("measurement".into(), if study.quick { "quick" } else { "full" }.into())],
        ..Report::default()
    }
}

/// Returns the measurement as JSON.
pub fn summary(study: &Study) -> Value {
    let errors = |errors: &Errors| json!({ "force": errors.force, "mean": errors.mean, "displacement": errors.displacement });
    let work: Vec<Value> = study
        .curves
        .iter()
        .map(|curve| {
            let points: Vec<Value> = curve
                .points
                .iter()
                .map(|point| {
                    json!({
                        "steps": point.steps, "ns_per_period": point.ns, "instructions_per_period": point.instructions,
                        "errors": errors(&point.errors),
                    })
                })
                .collect();
            let order = curve.order(|point| point.errors.force);
            json!({ "method": curve.method.name, "order_of_force": order, "points": points })
        })
        .collect();
    let claims: Vec<Value> = study.claims.iter().map(|claim| {
        let (unit, target) = match claim.target {
            Target::Times(target) => ("times, at least", target),
            Target::Nanoseconds(target) => ("ns, at most", target),
        };
        json!({
            "claim": claim.what, "target": target, "unit": unit, "by_time": claim.by_time, "by_instructions": claim.by_instructions,
            "pass": claim.holds(), "compared": claim.how,
        })
    }).collect();
    let hard: Vec<Value> =
        study
            .hard
            .iter()
            .map(|(case, found)| match found {
                Ok(found) => {
                    let checks: Vec<Value> = found.checks.iter().map(|check| {
                let (least, most) = check.within;
                json!({ "what": check.what, "found": check.found, "least": least, "most": most, "pass": check.holds() })
            }).collect();
                    json!({
                        "case": case.name, "problem": found.problem, "naive": found.naive, "chosen": found.chosen,
                        "checks": checks, "pass": found.holds(),
                    })
                }
                Err(error) => json!({ "case": case.name, "problem": error.to_string(), "pass": false }),
            })
            .collect();
    json!({
        "quick": study.quick, "rounds": study.rounds,
        "reference": {
            "friction_ratio": study.reference.sample.mean, "other_setting": errors(&study.reference.settings),
            "independent": errors(&study.reference.independent),
        },
        "work": work, "uncounted": study.uncounted, "claims": claims, "hard": hard, "pass": study.passes(),
    })
}
