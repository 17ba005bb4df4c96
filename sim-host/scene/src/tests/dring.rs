//! Scenes with a D-ring: it has its own contact, and a restraint needs a belt and its force.

use super::{example, says, sets};
use crate::load::load_text;

const CRASH: &str = include_str!("../../scenes/dring-crash.toml");

fn problems_of(text: &str, changes: &[&str]) -> String {
    match load_text("dring-crash.toml", text, &sets(changes)) {
        Ok(_) => panic!("nothing is wrong with {changes:?}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn an_actuator_that_is_none_is_named() {
    says(
        &problems_of(CRASH, &["rig.dring.actuator=tangental"]),
        &["`rig.dring.actuator`", "did you mean `tangential`?", "1 problem"],
    );
    says(&problems_of(CRASH, &["rig.dring.occupant=5"]), &["`rig.dring.occupant`", "5th", "1 problem"]);
    says(&problems_of(CRASH, &["rig.dring.slack_mm=10"]), &["give it in m: `slack_m`"]);
}

#[test]
fn low_friction_is_low() {
    says(&problems_of(CRASH, &["rig.dring.mu_low=0.4"]), &["low friction of 0.4 is more than high friction of 0.3", "1 problem"]);
}

#[test]
fn a_d_ring_is_its_own_contact_and_hangs_on_a_stack() {
    let contact = ["contact.dahl.mu=0.2", "contact.dahl.stiffness_n_per_m=1e6"];
    says(&problems_of(CRASH, &contact), &["[contact] has no place beside [rig.dring]", "the D-ring is one", "1 problem"]);
    says(&problems_of(CRASH, &["rig.dring.at_s=0.5"]), &["`rig.dring.at_s` is 0.5 s, but the run is over at 0.22 s"]);
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
fn it_reads_back_as_the_same_scene() {
    let scene = load_text("crash", CRASH, &sets(&["rig.dring.torso_kg=18"])).unwrap().scene;
    let text = crate::resolved::resolved_toml(&scene);
    assert_eq!(load_text("crash", &text, &[]).unwrap().scene, scene);
}
