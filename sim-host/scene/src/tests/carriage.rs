//! Scenes with a carriage: its contact, its spring, and what cannot happen to it.

use super::{example, report, says};
use crate::load::load_text;

const RAIL: &str = include_str!("../../scenes/seat-rail.toml");

fn problems_of(changes: &[&str]) -> String {
    report(RAIL, changes)
}

#[test]
fn a_carriage_has_static_friction() {
    let dahl = RAIL.replacen("[contact.lugre]\nmu = 0.25\nstatic_mu = 0.35", "[contact.dahl]\nmu = 0.25", 1);
    let dahl = dahl.replacen("stribeck_m_per_s = 3e-4\n", "", 1);
    says(
        &report(&dahl, &[]),
        &[
            "[rig.carriage] and [contact.dahl] do not go together",
            "[rig.carriage] needs [contact.lugre]",
            "it is Dahl's contact",
            "1 problem",
        ],
    );
    let lugre = [
        "contact.lugre.mu=0.3",
        "contact.lugre.static_mu=0.4",
        "contact.lugre.stiffness_n_per_m=1e6",
        "contact.lugre.stribeck_m_per_s=1e-3",
    ];
    says(
        &report(example(), &lugre),
        &[
            "[contact.lugre] and [rig.slider] do not go together",
            "[contact.lugre] needs [rig.carriage]",
            "[contact.dahl]",
            "1 problem",
        ],
    );
    assert!(load_text("a.toml", RAIL, &["contact.lugre.static_mu=0.25".to_owned()]).is_ok());
    says(&problems_of(&["contact.lugre.static_mu=0.2"]), &["static friction of 0.2 is less than kinetic friction of 0.25"]);
    says(&problems_of(&["contact.lugre.normal_n=1"]), &["`normal_n` has no place", "rig.carriage.normal_n"]);
    says(&problems_of(&["contact.lugre.sign=literal"]), &["friction that pumps a stack", "must be `passive`"]);
}

#[test]
fn a_pull_needs_a_spring() {
    says(
        &problems_of(&["rig.carriage.stiffness_n_per_m=0"]),
        &[
            "a pull of 1e-4 m/s by a spring without stiffness",
            "needs `rig.carriage.stiffness_n_per_m`",
            "rig.carriage.force_n",
            "1 problem",
        ],
    );
    assert!(
        load_text("a.toml", RAIL, &["rig.carriage.stiffness_n_per_m=0".to_owned(), "rig.carriage.pull_m_per_s=0".to_owned()])
            .is_ok()
    );
    says(&problems_of(&["rig.carriage.pull_at_s=9"]), &["rig.carriage.pull_at_s", "5.2", "1 problem"]);
    says(&problems_of(&["rig.carriage.mass_kg=0"]), &["`rig.carriage.mass_kg` is out of range", "from 1e-6", "1 problem"]);
}

#[test]
fn a_carriage_is_under_a_driven_tip_and_no_belt() {
    let fault = ["fault.0.kind=belt_stopped", "fault.0.at_s=1"];
    says(&problems_of(&fault), &["a carriage cannot be `belt_stopped`", "as the forces on it say", "1 problem"]);
    assert!(load_text("a.toml", RAIL, &["fault.0.kind=encoder_stuck".to_owned(), "fault.0.at_s=1".to_owned()]).is_ok());
    let study = include_str!("excited.toml");
    let (head, _) = study.split_once("[rig.sdof]").unwrap();
    let carriage = format!("{head}[rig.carriage]\nmass_kg = 1\nnormal_n = 1\n");
    says(&report(&carriage, &[]), &["[rig.carriage] has no place in a contact study", "the firmware drives", "1 problem"]);
}

#[test]
fn a_carriage_is_slow_against_the_vibration() {
    says(
        &problems_of(&["rig.carriage.mass_kg=0.01"]),
        &[
            "the carriage swings on spring and contact at 7293 Hz",
            "must be at most 4000 Hz",
            "a tenth of `controller.drive.frequency_hz`",
        ],
    );
    says(
        &problems_of(&["rig.carriage.damping_n_s_per_m=6e5"]),
        &["`rig.carriage.damping_n_s_per_m` damps", "at most 502", "1 problem"],
    );
    says(&problems_of(&["contact.lugre.sigma1=1e3"]), &["`contact.lugre.sigma1` damps", "at most 616", "1 problem"]);
}
