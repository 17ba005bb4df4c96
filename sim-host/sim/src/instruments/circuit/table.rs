//! Table of command, estimate and truth of the transducer.

use firmware::seam::transducer::Deviations;

use crate::instruments::View;
use crate::metrics::Metrics;
use crate::numbers::number;
use crate::record::Row;
use plant::circuit_of;
use report::statistics::mean;
use report::{TableBlock, rounded_to, stated};

/// Returns the table of command (or nominal value), estimate and truth.
pub(super) fn three_ways(run: &View, metrics: &Metrics) -> TableBlock {
    let steady: Vec<&Row> = run.steady().collect();
    let mean = |value: &dyn Fn(&Row) -> f64| mean(steady.iter().map(|row| value(row)));
    let controller = run.scene.controller;
    let tracking = &controller.tracking;
    let found = run.record.last.transducer;
    let truth = circuit_of(&run.scene);
    let identified =
        |value: fn(&firmware::seam::transducer::Transducer) -> f32| found.as_ref().map(|found| f64::from(value(found)));
    let velocity_estimate = tracking
        .nominal_force_factor_n_per_v
        .and_then(|nominal| mean(&|row| row.motional_current_a).map(|amperes| amperes / nominal));
    let mut rows = vec![
        (
            "drive frequency, steady [Hz]",
            mean(&|row| row.frequency_hz),
            mean(&|row| row.resonance_estimate_hz),
            mean(&|row| row.truth.series_resonance_hz),
        ),
        (
            "tip velocity, steady [m/s]",
            run.scene.ordered_velocity_m_per_s(),
            velocity_estimate,
            metrics.get("tip_velocity_m_per_s"),
        ),
        (
            "series resonance [Hz]",
            Some(controller.drive.frequency_hz),
            identified(|t| t.series_resonance_hz),
            Some(truth.series_resonance_hz()),
        ),
        (
            "parallel resonance [Hz]",
            None,
            identified(|t| t.parallel_resonance_hz),
            Some(truth.series_resonance_hz() * (1.0 + truth.cm_f / truth.c0_f).sqrt()),
        ),
        ("Q", Some(tracking.nominal_q), identified(|t| t.q), Some(truth.q())),
        ("Rm [ohm]", None, identified(|t| t.rm_ohm), Some(truth.rm_ohm)),
        ("Lm [mH]", None, identified(|t| t.lm_h * 1e3), Some(truth.lm_h * 1e3)),
        ("Cm [nF]", None, identified(|t| t.cm_f * 1e9), Some(truth.cm_f * 1e9)),
        ("C0 [nF]", tracking.nominal_c0_f.map(|c0_f| c0_f * 1e9), identified(|t| t.c0_f * 1e9), Some(truth.c0_f * 1e9)),
        ("coupling", None, identified(|t| t.coupling), Some((truth.cm_f / (truth.c0_f + truth.cm_f)).sqrt())),
    ];
    rows.retain(|row| row.2.is_some());
    let deviation = |what: &str| found.as_ref().and_then(|found| stated_sd(what, &found.deviations));
    let rows = rows
        .into_iter()
        .map(|(what, command, found, truth)| {
            let sd = deviation(if what.starts_with("drive frequency") { "series resonance [Hz]" } else { what });
            let shown = |value: f64| sd.map_or_else(|| number(value), |sd| rounded_to(value, sd));
            let cell = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), shown);
            let stated_sd = deviation(what).zip(found).map(|(sd, found)| stated(found, sd).1);
            vec![
                what.into(),
                command.map_or_else(|| "–".into(), number),
                cell(found),
                stated_sd.unwrap_or_else(|| "–".into()),
                cell(truth),
            ]
        })
        .collect();
    TableBlock::new(
        "three-ways",
        "Command, estimate, truth",
        if run.scene.stator().is_some() {
            "The circuit is that of the stator without its rotor, seen from the first lane; friction adds its loss. The tip \
             velocity is that of the crests across the ring."
        } else if run.scene.belt().is_some() {
            "The circuit is that of the stack with the damping of the belt under its horn, at the beginning of the run."
        } else {
            "The circuit is that of the stack alone, at the beginning of the run; a contact adds its stiffness and loss."
        },
        &["", "set point or nominal value", "controller's estimate", "its standard deviation", "plant's truth"],
        rows,
    )
}

/// Returns the standard deviation that the controller states of an identified number, in the unit
/// of its row.
fn stated_sd(what: &str, deviations: &Deviations) -> Option<f64> {
    let sd = match what {
        "series resonance [Hz]" => deviations.series_resonance_hz,
        "parallel resonance [Hz]" => deviations.parallel_resonance_hz,
        "Q" => deviations.q,
        "Rm [ohm]" => deviations.rm_ohm,
        "Lm [mH]" => deviations.lm_h * 1e3,
        "Cm [nF]" => deviations.cm_f * 1e9,
        "C0 [nF]" => deviations.c0_f * 1e9,
        "coupling" => deviations.coupling,
        _ => return None,
    };
    Some(sd.into())
}
