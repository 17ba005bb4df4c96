//! Tables of the measurement.

use super::claims::{Claim, Target};
use super::hard::{HardCase, HardResult};
use super::reference::{INDEPENDENT_STEPS, Reference, SETTINGS};
use super::sample::Errors;
use super::study::Study;
use super::work::Curve;
use contact::SolveError;
use report::TableBlock;

/// Tabulates the checks of the reference.
pub fn reference(reference: &Reference) -> TableBlock {
    let [(n, order), (other_n, other_order)] = SETTINGS;
    let row = |name: String, errors: &Errors| {
        let cells = [errors.force, errors.mean, errors.displacement].map(|error| format!("{error:.1e}"));
        [vec![name], cells.into()].concat()
    };
    TableBlock::new(
        "reference",
        "The reference and its checks",
        format!("Taylor series of order {order}, {n} steps a period; r = {:.12}", reference.sample.mean),
        &["compared with", "F(t)", "mean r", "x(t)"],
        vec![
            row(format!("taylor order {other_order}, {other_n} steps"), &reference.settings),
            row(format!("rk4-events, {INDEPENDENT_STEPS} steps"), &reference.independent),
        ],
    )
}

/// Tabulates cost and error of every setting.
pub fn work(study: &Study) -> TableBlock {
    let instructions = study.uncounted.as_ref().map_or_else(
        || "Instructions are of this build, counted over 8 periods.".to_owned(),
        |reason| format!("No instructions: {reason}."),
    );
    TableBlock::new(
        "work",
        "Cost and error on the standard case (Table 4.1, 384 N, 60 kHz, velocity ratio 0.5, from rest, periods 100 to 200)",
        format!("Times are minima over {} rounds in which all settings take turns. {instructions}", study.rounds),
        &["method", "n", "ns/period", "instr./period", "err F(t)", "err mean r", "err x(t)", "order of F"],
        study.curves.iter().flat_map(rows_of).collect(),
    )
}

fn rows_of(curve: &Curve) -> Vec<Vec<String>> {
    let order = curve.order(|point| point.errors.force).map_or_else(|| "-".into(), |order| format!("{order:.1}"));
    let row = |(index, point): (usize, &super::work::Point)| {
        vec![
            curve.method.name.into(),
            point.steps.to_string(),
            format!("{:.0}", point.ns),
            point.instructions.map_or_else(|| "-".into(), |count| format!("{count:.0}")),
            format!("{:.1e}", point.errors.force),
            format!("{:.1e}", point.errors.mean),
            format!("{:.1e}", point.errors.displacement),
            if index == 0 { order.clone() } else { String::new() },
        ]
    };
    curve.points.iter().enumerate().map(row).collect()
}

/// Tabulates the claims.
pub fn claims(claims: &[Claim]) -> TableBlock {
    let value = |claim: &Claim, measured: Option<f64>| match (measured, claim.target) {
        (None, _) => "-".into(),
        (Some(measured), Target::Times(_)) => format!("{measured:.0}x"),
        (Some(measured), Target::Nanoseconds(_)) => format!("{measured:.0} ns"),
    };
    let row = |claim: &Claim| {
        vec![
            claim.what.clone(),
            match claim.target {
                Target::Times(target) => format!(">= {target:.0}x"),
                Target::Nanoseconds(target) => format!("<= {target:.0} ns"),
            },
            value(claim, claim.by_time),
            value(claim, claim.by_instructions),
            verdict(claim.holds()).into(),
            claim.how.clone(),
        ]
    };
    TableBlock::new(
        "claims",
        "Claims",
        "Costs are read from the curves of the table above, by linear interpolation on logarithmic axes.",
        &["claim", "target", "by time", "by instr.", "", "compared"],
        claims.iter().map(row).collect(),
    )
}

/// Returns the verdict in words.
pub fn verdict(holds: Option<bool>) -> &'static str {
    match holds {
        Some(true) => "PASS",
        Some(false) => "MISS",
        None => "not measured",
    }
}

/// Tabulates the hard cases for a terminal: the methods, the number of invariants that hold, and
/// those that are missed.
pub fn hard_in_short(cases: &[(&'static HardCase, Result<HardResult, SolveError>)]) -> TableBlock {
    let row = |(case, found): &(&'static HardCase, Result<HardResult, SolveError>)| match found {
        Ok(found) => {
            let missed: Vec<String> = found.checks.iter().filter(|check| !check.holds()).map(ToString::to_string).collect();
            let count = format!("{} of {}", found.checks.len() - missed.len(), found.checks.len());
            let chosen = if missed.is_empty() { found.chosen.clone() } else { missed.join("; ") };
            vec![case.name.into(), found.naive.clone(), chosen, count, verdict(Some(found.holds())).into()]
        }
        Err(error) => vec![case.name.into(), "-".into(), error.to_string(), "-".into(), verdict(Some(false)).into()],
    };
    TableBlock::new(
        "hard",
        "Hard cases",
        "Naive: Runge-Kutta with the steps of the thesis. Means are friction ratios. The invariants are in report.html.",
        &["case", "naive", "chosen method, or missed invariants", "invariants held", ""],
        cases.iter().map(row).collect(),
    )
}

/// Tabulates the hard cases with all invariants.
pub fn hard(cases: &[(&'static HardCase, Result<HardResult, SolveError>)]) -> TableBlock {
    let row = |(case, found): &(&'static HardCase, Result<HardResult, SolveError>)| match found {
        Ok(found) => {
            let checks: Vec<String> = found.checks.iter().map(ToString::to_string).collect();
            let holds = verdict(Some(found.holds())).into();
            vec![case.name.into(), found.problem.into(), found.naive.clone(), found.chosen.clone(), checks.join("; "), holds]
        }
        Err(error) => {
            vec![case.name.into(), error.to_string(), "-".into(), "-".into(), "-".into(), verdict(Some(false)).into()]
        }
    };
    TableBlock::new(
        "hard",
        "Hard cases",
        "Naive: Runge-Kutta with the steps of the thesis. Means are friction ratios.",
        &["case", "difficulty", "naive", "chosen method", "invariants", ""],
        cases.iter().map(row).collect(),
    )
}
