//! Scenes with a belt under a horn: its contact, amplitude and trigger.

use super::{example, report, says, sets};
use crate::load::load_text;

const BELT: &str = include_str!("../../scenes/experiment-2.toml");

fn problems_of(changes: &[&str]) -> String {
    report(BELT, changes)
}

/// Returns the scene without its grid and without the table with this header.
fn without(header: &str) -> String {
    BELT.split_inclusive("\n\n").filter(|part| !part.contains("[grid]") && !part.starts_with(header)).collect()
}

#[test]
fn belt_amplitude_is_a_fraction() {
    says(
        &problems_of(&["rig.belt.amplitude_fraction=70"]),
        &["out of range", "from 0.001 to 1", "0.7 is 70 %", "--set:1:29", "1 problem"],
    );
    says(&problems_of(&["rig.belt.amplitude_fraction=1.01"]), &["from 0.001 to 1"]);
    says(&problems_of(&["rig.belt.amplitude_percent=70"]), &["rig.belt", "amplitude_percent"]);
    says(
        &problems_of(&["rig.belt.load_n=-270"]),
        &["`rig.belt.load_n` is out of range", "from 1 to 10000 N", "Force of the horn", "1 problem"],
    );
    says(&problems_of(&["rig.belt.lag_s=-1"]), &["`rig.belt.lag_s` is out of range", "from 0 to 100 s"]);
}

#[test]
fn belt_replaces_amplitude_keys() {
    for (change, key) in
        [("controller.drive.velocity_m_per_s=7.5", "velocity_m_per_s"), ("controller.drive.amplitude_v=500", "amplitude_v")]
    {
        let (has_no_place, instead) =
            (format!("`controller.drive.{key}` cannot be combined with [rig.belt]"), "`rig.belt.amplitude_fraction` replaces it");
        says(&problems_of(&[change]), &[&has_no_place, instead, "0.7 is 70 %", "--set:1:", "1 problem"]);
    }
    let bare = BELT.replacen("scan_v = 40.0\n", "", 1);
    says(&report(&bare, &[]), &["needs `scan_v` as well", "1 problem"]);
    let bare = BELT.replacen("nominal_force_factor_n_per_v = 0.331\n", "", 1);
    says(&report(&bare, &[]), &["needs the force factor", "amplitude_fraction", "1 problem"]);
}

#[test]
fn a_belt_and_its_law_need_each_other() {
    let no_contact = without("[contact.empirical]");
    says(&report(&no_contact, &[]), &["[rig] without [contact]", "needs [contact]", "add [contact.empirical]", "1 problem"]);
    let no_belt = without("[rig.belt]");
    says(
        &report(&no_belt, &["controller.drive.velocity_m_per_s=7"]),
        &["[contact] without [rig]", "add [rig.belt]", "1 problem"],
    );
    let slider = ["rig.slider.speed_m_per_s=0.025", "rig.slider.self_weight_n=1", "controller.drive.velocity_m_per_s=7"];
    let no_grid = without("no such header");
    says(
        &report(&no_grid, &slider),
        &[
            "[contact.empirical] and [rig.slider] cannot be combined",
            "[contact.empirical] needs [rig.belt]",
            "[contact.dahl]",
            "1 problem",
        ],
    );
    let dahl = ["contact.dahl.mu=0.3", "contact.dahl.stiffness_n_per_m=1e6"];
    says(
        &problems_of(&dahl),
        &[
            "[rig.belt] and [contact.dahl] cannot be combined",
            "[rig.belt] needs [contact.empirical]",
            "defaults for all",
            "1 problem",
        ],
    );
    says(
        &report(example(), &["contact.empirical.mu=0.3"]),
        &["[contact.empirical] and [rig.slider] cannot be combined", "1 problem"],
    );
}

#[test]
fn belt_needs_a_driven_horn() {
    let study = include_str!("excited.toml");
    let (head, _) = study.split_once("[rig.sdof]").unwrap();
    let belt = "[rig.belt]\nload_n = 270\nspeed_m_per_s = 0.025\namplitude_fraction = 0.7\n";
    says(
        &report(&format!("{head}{belt}"), &[]),
        &["[rig.belt] cannot be used in a contact study", "a stack that the firmware drives"],
    );
    let (head, tail) = study.split_once("[contact.dahl]").unwrap();
    let (_, rig) = tail.split_once("[rig.sdof]").unwrap();
    let empirical = format!("{head}[contact.empirical]\nmu = 0.3\n\n[rig.sdof]{rig}");
    says(&report(&empirical, &[]), &["[contact.empirical] cannot be used in a contact study", "[contact.hertz]"]);
    let usm = include_str!("../../scenes/usm.toml");
    says(&report(&format!("{usm}\n{belt}"), &[]), &["exclude each other"]);
}

#[test]
fn trigger_delay_needs_listed_windows() {
    let repeated = ["controller.burst.period_s=1", "controller.burst.duty=0.5"];
    says(
        &report(&without("none"), &repeated),
        &["a trigger delay applies to listed windows", "`trigger_delay_s` of 0", "1 problem"],
    );
    let prompt = [&repeated[..], &["rig.belt.trigger_delay_s=0"]].concat();
    assert!(load_text("a.toml", &without("none"), &sets(&prompt)).is_ok());
}

/// An amplitude beyond the firmware's range is reported at the key of the belt.
#[test]
fn firmware_limit_is_reported_at_the_belt_key() {
    let limit = ["controller.limits.current_a=2"];
    says(&problems_of(&limit), &["the firmware refuses `rig.belt.amplitude_fraction`", "must be"]);
}

#[test]
fn the_law_has_defaults() {
    let bare = without("[contact.empirical]") + "\n[contact.empirical]\n";
    let scene = load_text("a.toml", &bare, &[]).unwrap_or_else(|error| panic!("{error}")).scene;
    let driven = scene.driven().unwrap();
    let (contact, belt) = driven.belt().unwrap();
    assert_eq!(contact.law(), contact::empirical::EmpiricalLaw::FITTED);
    assert_eq!((belt.full_amplitude_m, driven.trigger_delay_s()), (85e-6, 0.05));
    let ordered = driven.ordered_velocity_m_per_s().unwrap();
    assert!((ordered - std::f64::consts::TAU * 20e3 * 0.7 * 85e-6).abs() < 1e-12, "{ordered}");
}
