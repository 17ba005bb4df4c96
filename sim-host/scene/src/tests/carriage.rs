//! Scenes with a carriage: its contact, its spring, and faults that it cannot have.

use super::{example, report, says};
use crate::load::load_text;

const RAIL: &str = include_str!("../../scenes/seat-rail.toml");

fn problems_of(changes: &[&str]) -> String {
    report(RAIL, changes)
}

#[test]
fn carriage_needs_static_friction() {
    let dahl = RAIL.replacen("[contact.lugre]\nmu = 0.25\nstatic_mu = 0.35", "[contact.dahl]\nmu = 0.25", 1);
    let dahl = dahl.replacen("stribeck_m_per_s = 3e-4\n", "", 1);
    says(
        &report(&dahl, &[]),
        &[
            "[rig.carriage] and [contact.dahl] cannot be combined",
            "[rig.carriage] needs [contact.lugre]",
            "the contact is Dahl's",
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
            "[contact.lugre] and [rig.slider] cannot be combined",
            "[contact.lugre] needs [rig.carriage]",
            "[contact.dahl]",
            "1 problem",
        ],
    );
    assert!(load_text("a.toml", RAIL, &["contact.lugre.static_mu=0.25".to_owned()]).is_ok());
    says(&problems_of(&["contact.lugre.static_mu=0.2"]), &["static friction of 0.2 is less than kinetic friction of 0.25"]);
    says(&problems_of(&["contact.lugre.normal_n=1"]), &["`normal_n` cannot be used", "rig.carriage.normal_n"]);
    says(&problems_of(&["contact.lugre.sign=literal"]), &["friction that feeds energy into a stack", "must be `passive`"]);
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
fn carriage_refuses_belt_faults_and_contact_studies() {
    let fault = ["fault.0.kind=belt_stopped", "fault.0.at_s=1"];
    says(
        &problems_of(&fault),
        &["a carriage cannot have the fault `belt_stopped`", "according to the forces on it", "1 problem"],
    );
    assert!(load_text("a.toml", RAIL, &["fault.0.kind=encoder_stuck".to_owned(), "fault.0.at_s=1".to_owned()]).is_ok());
    let study = include_str!("excited.toml");
    let (head, _) = study.split_once("[rig.sdof]").unwrap();
    let carriage = format!("{head}[rig.carriage]\nmass_kg = 1\nnormal_n = 1\n");
    says(&report(&carriage, &[]), &["[rig.carriage] cannot be used in a contact study", "the firmware drives", "1 problem"]);
}

#[test]
fn carriage_must_be_slow_against_the_vibration() {
    says(
        &problems_of(&["rig.carriage.mass_kg=0.01"]),
        &[
            "the carriage oscillates on spring and contact at 7293 Hz",
            "must be at most 4000 Hz",
            "a tenth of `controller.drive.frequency_hz`",
        ],
    );
    says(
        &problems_of(&["rig.carriage.damping_n_s_per_m=6e5"]),
        &["`rig.carriage.damping_n_s_per_m` stops the motion", "at most 502", "1 problem"],
    );
    says(&problems_of(&["contact.lugre.sigma1=1e3"]), &["`contact.lugre.sigma1` stops the motion", "at most 616", "1 problem"]);
}
