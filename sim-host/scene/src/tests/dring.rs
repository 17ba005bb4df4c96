//! Scenes with a D-ring: it has its own contact, and a restraint needs a belt with a force sensor.

use super::{example, says, sets};
use crate::load::load_text;

const CRASH: &str = include_str!("../../scenes/dring-crash.toml");

fn problems_of(text: &str, changes: &[&str]) -> String {
    match load_text("dring-crash.toml", text, &sets(changes)) {
        Ok(_) => panic!("there is no problem with {changes:?}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn unknown_actuators_have_a_nearest_name() {
    says(
        &problems_of(CRASH, &["rig.dring.actuator=tangental"]),
        &["`rig.dring.actuator`", "did you mean `tangential`?", "1 problem"],
    );
    says(&problems_of(CRASH, &["rig.dring.occupant=5"]), &["`rig.dring.occupant`", "5th", "1 problem"]);
    says(&problems_of(CRASH, &["rig.dring.slack_mm=10"]), &["give it in m: `slack_m`"]);
}

#[test]
fn mu_low_must_not_exceed_mu_high() {
    says(&problems_of(CRASH, &["rig.dring.mu_low=0.4"]), &["low friction of 0.4 is more than high friction of 0.3", "1 problem"]);
}

#[test]
fn dring_excludes_a_contact() {
    let contact = ["contact.dahl.mu=0.2", "contact.dahl.stiffness_n_per_m=1e6"];
    says(
        &problems_of(CRASH, &contact),
        &["[contact] cannot be combined with [rig.dring]", "the D-ring is the contact", "1 problem"],
    );
    says(&problems_of(CRASH, &["rig.dring.at_s=0.5"]), &["`rig.dring.at_s` is 0.5 s, but the run ends at 0.22 s"]);
}

#[test]
fn a_restraint_needs_a_belt_and_its_force() {
    says(
        &problems_of(&CRASH.replace("force_hz = 500\n", ""), &[]),
        &["without `sensors.force_hz`", "the force in the belt", "1 problem"],
    );
    says(&problems_of(example(), &["controller.restraint.sensed_n=300"]), &["[controller.restraint] without [rig.dring]"]);
    says(
        &problems_of(CRASH, &["controller.restraint.latest_n=200"]),
        &["the firmware refuses `controller.restraint.latest_n`", "from 1000 to 100000 N"],
    );
    let burst = ["controller.burst.on_s=[0.1]", "controller.burst.off_s=[0.2]"];
    says(&problems_of(CRASH, &burst), &["[controller.burst] and [controller.restraint] exclude each other"]);
}

#[test]
fn dring_scene_reads_back_the_same() {
    let scene = load_text("crash", CRASH, &sets(&["rig.dring.torso_kg=18"])).unwrap().scene;
    let text = crate::resolved::resolved_toml(&scene);
    assert_eq!(load_text("crash", &text, &[]).unwrap().scene, scene);
}

#[test]
fn ring_needs_a_direction() {
    let ring = ["rig.dring.actuator=ring"];
    says(
        &problems_of(CRASH, &ring),
        &["the direction of the ring's vibration is missing", "needs `ring_angle_deg`", "1 problem"],
    );
    says(
        &problems_of(CRASH, &["rig.dring.ring_angle_deg=0"]),
        &["`ring_angle_deg` with the actuator `ideal`", "for `ring` and `stack`", "1 problem"],
    );
    says(
        &problems_of(CRASH, &["rig.dring.ring_axis_deg=90"]),
        &["`ring_axis_deg` has no effect without `ring_angle_deg`", "omit it", "1 problem"],
    );
    says(
        &problems_of(CRASH, &["rig.dring.actuator=ring", "rig.dring.ring_angle_deg=181"]),
        &["`rig.dring.ring_angle_deg`", "180"],
    );
    says(
        &problems_of(CRASH, &["rig.dring.actuator=ring", "rig.dring.ring_angle_deg=0", "rig.dring.ring_hz=40e3"]),
        &["`ring_hz` has no effect without `ring_normal_part = \"fitted\"`", "1 problem"],
    );
}

#[test]
fn fitted_normal_part_has_a_largest_amplitude() {
    let fitted = |more: &str| {
        let changes = ["rig.dring.actuator=ring", "rig.dring.ring_angle_deg=0", "rig.dring.ring_normal_part=fitted", more];
        problems_of(CRASH, &changes)
    };
    says(&fitted("rig.dring.tip_m_per_s=12"), &["12 m/s at 20000 Hz are an amplitude of 95 um", "at most 85 um", "1 problem"]);
    says(&fitted("rig.dring.ring_hz=5e3"), &["5 m/s at 5000 Hz are an amplitude of 159 um", "at most 85 um", "1 problem"]);
    says(
        &problems_of(CRASH, &["rig.dring.actuator=stack", "rig.dring.ring_angle_deg=0", "rig.dring.ring_normal_part=fitted"]),
        &["the fitted normal part with the actuator `stack`", "for `ring`", "1 problem"],
    );
}

#[test]
fn a_ring_reads_back_as_the_same_scene() {
    let changes = [
        "rig.dring.actuator=ring",
        "rig.dring.ring_angle_deg=-30",
        "rig.dring.ring_axis_deg=40",
        "rig.dring.ring_normal_part=fitted",
    ];
    let scene = load_text("crash", CRASH, &sets(&changes)).unwrap_or_else(|error| panic!("{error}")).scene;
    let text = crate::resolved::resolved_toml(&scene);
    assert_eq!(load_text("crash", &text, &[]).unwrap_or_else(|error| panic!("{error}")).scene, scene);
    let vibration = scene.driven().and_then(|scene| scene.dring()).and_then(|dring| dring.ring_vibration());
    let expected = crate::RingVibration { angle_deg: -30.0, axis_deg: 40.0, fitted: Some((20e3, 8e-3)) };
    assert_eq!(vibration, Some(expected));
}
