//! Messages about a vibration at an angle to the sliding.

use super::{report, says};
use crate::builtin;
use crate::load::load_text;

/// Returns the report on the built-in scene with changes.
fn said(changes: &[&str]) -> String {
    report(builtin::text("contact-transverse").unwrap_or_default(), changes)
}

const DAHL: [&str; 3] = ["contact.dahl.mu=0.1", "contact.dahl.normal_n=1", "contact.dahl.stiffness_n_per_m=5e4"];

/// Returns the same report for bristle friction.
fn bristle_report(change: &str) -> String {
    said(&[&DAHL[..], &[change]].concat())
}

#[test]
fn angle_needs_a_prescribed_vibration() {
    says(&said(&["excitation.angle_deg=91"]), &["`excitation.angle_deg` is out of range"]);
    says(&said(&["excitation.angle_deg=-1"]), &["`excitation.angle_deg` is out of range"]);
    let mass = ["rig.sdof.mass_kg=0.02", "rig.sdof.stiffness_n_per_m=133e6", "excitation.force_n=384"];
    says(&said(&mass), &["at an angle of 90 degrees", "not with [rig.sdof]", "only `rig.kinematic`"]);
    let hertz = ["contact.hertz.mu=0.1", "contact.hertz.normal_n=1", "contact.hertz.stiffness_n_per_m15=1e10"];
    says(&said(&hertz), &["at an angle of 90 degrees", "not with [contact.hertz]"]);
    let compliant = report(builtin::text("contact-compliant").unwrap_or_default(), &["excitation.angle_deg=10"]);
    says(&compliant, &["at an angle of 10 degrees", "not with [contact.compliant]"]);
}

#[test]
fn an_angle_has_its_own_method() {
    for method in ["linexp", "frozen", "taylor", "rk4", "rk4-events", "midpoint", "closed"] {
        says(&bristle_report(&format!("integrator.method={method}")), &[&format!("{method} does not apply here"), "collocation"]);
    }
    says(&said(&["integrator.method=collocation"]), &["collocation does not apply here", "only a closed form"]);
    says(
        &said(&["excitation.angle_deg=0", "integrator.method=collocation"]),
        &["collocation does not apply here", "`excitation.angle_deg`"],
    );
    says(&bristle_report("integrator.steps_per_period=100"), &["not solved in steps", "omit it"]);
    says(&bristle_report("integrator.tolerance_of=record"), &["the record has no tolerance", "only the mean"]);
}

#[test]
fn closed_form_needs_periodic_waveform_and_load() {
    says(
        &said(&["excitation.waveform=random", "excitation.hold_time_s=1e-5"]),
        &["a random vibration at an angle", "must be periodic"],
    );
    let load = ["disturbance.0.at_s=1e-3", "disturbance.0.key=contact.normal_n", "disturbance.0.to=1"];
    says(&said(&load), &["needs a constant load", "not with [contact.coulomb]"]);
    let text = builtin::text("contact-transverse").unwrap_or_default();
    for changes in [&["excitation.waveform=triangle"][..], &["excitation.angle_deg=0"], &["excitation.angle_deg=1e-6"]] {
        let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
        assert!(load_text("a.toml", text, &changes).is_ok());
    }
    let loads: Vec<String> = DAHL.iter().chain(&load).map(|&change| change.to_owned()).collect();
    assert!(load_text("a.toml", text, &loads).is_ok());
}
