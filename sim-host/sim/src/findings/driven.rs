//! A driven run in words and tables.

mod belt;
pub use belt::law as belt_law;
pub(super) mod crash;
mod motor;
mod processor;

use std::fmt::Write as _;

use firmware::seam::fault::Limit;
use firmware::seam::mode::Mode;
use firmware::seam::transducer::Deviations;

use super::{Line, precise};
use crate::metrics::driven::View;
use crate::record::Row;
use crate::study::Study;
use crate::study::driven::Run;
use plant::circuit_of;
use report::TableBlock;

/// Where the controller ran, and what the three ways are.
pub(super) fn preface(run: &Run) -> String {
    format!(
        "{}, against a simulated {}. Command is what the controller played, estimate what it believed, truth what the \
         simulated plant did; the controller sees converter codes only.",
        run.level,
        match (run.scene.stator(), run.scene.dring()) {
            (Some(_), _) => "stator and rotor",
            (None, Some(_)) => "stack, seat belt and torso",
            (None, None) => "stack and contact",
        },
    )
}

/// What a reader must know before the numbers.
pub(super) fn remarks(run: &Run) -> Vec<String> {
    let mut remarks = Vec::new();
    if let Some(fault) = run.record.last.fault {
        remarks.push(format!("The controller ended in fault {}: {fault:?}.", fault.code()));
    }
    let limit = run.record.rows.iter().rfind(|row| row.drive_v > 0.0).map(|row| row.limit);
    if let Some(limit) = limit.and_then(|code| Limit::try_from(code).ok()) {
        remarks.push(format!("In its last block under drive the controller was under limit {}: {limit:?}.", limit as u8));
    }
    if let Some(film) = &run.record.crash {
        remarks.extend(crash::remarks(run, film));
        return remarks;
    }
    let view = View::new(&run.scene, &run.record);
    if run.record.last.fault.is_none() && view.steady().next().is_none() {
        let running = view.plays_from(Mode::Run).map_or("was not reached".to_owned(), |s| format!("began at {s:.3} s"));
        remarks.push(format!("There is no steady block with the drive ON, so most metrics are missing: the run {running}."));
    }
    remarks
}

/// The numbers that come first: label, metric, unit.
const HEADLINE: &[Line] = &[
    ("friction reduction", "reduction_percent", "%"),
    ("friction, drive OFF", "friction_off_n", "N"),
    ("friction, drive ON", "friction_on_n", "N"),
    ("frequency bias", "frequency_bias_hz", "Hz"),
    ("acquired in", "acquire_time_ms", "ms"),
    ("relocked to 20 Hz in", "relock_time_20hz_ms", "ms"),
    ("tip velocity", "tip_velocity_m_per_s", "m/s"),
    ("rotor speed", "rotor_speed_rad_per_s", "rad/s"),
    ("backward wave", "backward_wave_percent", "%"),
    ("rotor over surface speed", "rotor_speed_ratio", ""),
    ("stops in", "stop_time_ms", "ms"),
    ("belt stops to drive OFF", "belt_stop_to_mute_ms", "ms"),
    ("rings down in", "ring_down_ms", "ms"),
    ("largest energy into a millimetre of belt", "exposure_j_per_mm", "J"),
    ("simulated s per wall s", "simulated_s_per_wall_s", ""),
];

/// The numbers that come first of this run.
pub(super) fn headline(run: &Run) -> &'static [Line] {
    if run.record.crash.is_some() { crash::HEADLINE } else { HEADLINE }
}

/// The fault that the run ended in, as a headline.
pub(super) fn fault(run: &Run) -> Option<(String, String)> {
    run.record.rows.last().filter(|row| row.fault != 0).map(|row| ("ended in fault".to_owned(), row.fault.to_string()))
}

/// The tables of a driven run.
pub(super) fn tables(study: &Study, run: &Run) -> Vec<TableBlock> {
    let crash = run.record.crash.as_ref().map(crash::belts);
    let motor = motor::closed_forms(study, &run.scene);
    let belt = belt::tables(study, &run.scene);
    let processor = processor::table(study, run);
    crash.into_iter().chain([three_ways(study, run)]).chain(motor).chain(belt).chain(processor).collect()
}

/// Where the numbers come from.
pub(super) fn footer(run: &Run) -> Vec<(&'static str, String)> {
    vec![
        ("drive hash", format!("{:016x}", run.record.drive_hash)),
        ("plant states", run.record.plant_states.to_string()),
        ("level", run.level.to_string()),
    ]
}

/// How it was run, in one line.
pub(super) fn manner(study: &Study, run: &Run) -> String {
    let speed = study.metrics.get("simulated_s_per_wall_s");
    let speed = speed.map_or_else(String::new, |speed| format!("{} simulated seconds per wall second, ", super::number(speed)));
    format!("{}; {speed}{} plant states; drive hash {:016x}", run.level, run.record.plant_states, run.record.drive_hash)
}

/// How far an interrupted run came, s.
pub(super) fn reached_s(run: &Run) -> f64 {
    run.record.rows.last().map_or(0.0, |row| row.time_s)
}

/// The modes that the controller went through, and when.
pub(super) fn modes(run: &Run) -> String {
    let mut text = String::new();
    let mut last = None;
    for row in &run.record.rows {
        if last != Some((row.mode, row.fault)) {
            last = Some((row.mode, row.fault));
            let fault = if row.fault == 0 { String::new() } else { format!(" {}", row.fault) };
            let _ = writeln!(text, "{:12.6} s  {:?}{fault}", row.time_s, row.mode);
        }
    }
    text
}

/// Command (or what the controller was told), estimate, truth.
fn three_ways(study: &Study, run: &Run) -> TableBlock {
    let view = View::new(&run.scene, &run.record);
    let steady: Vec<&Row> = view.steady().collect();
    let mean = |value: &dyn Fn(&Row) -> f64| {
        (!steady.is_empty()).then(|| steady.iter().map(|row| value(row)).sum::<f64>() / steady.len() as f64)
    };
    let controller = run.scene.controller;
    let tracking = &controller.tracking;
    let found = run.record.last.transducer;
    let truth = circuit_of(&run.scene);
    let identified =
        |value: fn(&firmware::seam::transducer::Transducer) -> f32| found.as_ref().map(|found| f64::from(value(found)));
    let velocity_estimate =
        tracking.nominal_force_factor_n_per_v.and_then(|told| mean(&|row| row.motional_current_a).map(|amperes| amperes / told));
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
            study.metrics.get("tip_velocity_m_per_s"),
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
        ("C0 [nF]", Some(tracking.nominal_c0_f * 1e9), identified(|t| t.c0_f * 1e9), Some(truth.c0_f * 1e9)),
        ("coupling", None, identified(|t| t.coupling), Some((truth.cm_f / (truth.c0_f + truth.cm_f)).sqrt())),
    ];
    rows.retain(|row| row.2.is_some());
    let cell = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), precise);
    let deviation = |what: &str| found.as_ref().and_then(|found| stated(what, &found.deviations));
    let rows = rows
        .into_iter()
        .map(|(what, told, found, truth)| vec![what.into(), cell(told), cell(found), cell(deviation(what)), cell(truth)])
        .collect();
    TableBlock::new(
        "three-ways",
        "Command, estimate, truth",
        if run.scene.stator().is_some() {
            "The circuit is what the first lane shows of the stator without its rotor; friction adds its loss. The tip velocity is the \
             crests', across the ring."
        } else if run.scene.belt().is_some() {
            "The circuit is the stack's with the damping of the belt under its horn, at the beginning of the run."
        } else {
            "The circuit is the stack's by itself, at the beginning of the run; a contact adds its stiffness and loss."
        },
        &["", "command, or told", "controller's estimate", "its standard deviation", "plant's truth"],
        rows,
    )
}

/// The standard deviation that the controller states of an identified number, in the unit of its row.
fn stated(what: &str, deviations: &Deviations) -> Option<f64> {
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
