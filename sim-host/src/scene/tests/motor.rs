//! Scenes with a motor: a stator instead of a stack, a rotor on it.

use super::{example, says, sets};
use crate::scene::load::load_text;

const USM: &str = include_str!("../../../scenes/usm.toml");

fn told(text: &str, changes: &[&str]) -> String {
    match load_text("usm.toml", text, &sets(changes)) {
        Ok(_) => panic!("nothing is wrong with {changes:?}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_stack_and_a_stator_exclude_each_other() {
    let stack = "[stack.bvd]\nc0_f = 3e-7\nseries_resonance_hz = 4e4\nq = 60\ncoupling = 0.25\n";
    says(&told(&format!("{USM}\n{stack}"), &[]), &["[stack] and [stator] exclude each other", "is given already", "1 problem"]);
}

#[test]
fn a_stator_has_a_rotor_and_no_contact() {
    let contact = ["contact.dahl.mu=0.2", "contact.dahl.stiffness_n_per_m=1e6"];
    says(&told(USM, &contact), &["[contact] has no place beside [stator]", "[rig.rotor]", "1 problem"]);
    let rotor = "[rig.rotor]\ninertia_kg_m2 = 1e-6\npreload_n = 1\nmu = 0.2\nradius_m = 0.01\ncontact_stiffness_n_per_m = 1e7\n";
    let without: String =
        example().split_inclusive("\n\n").filter(|part| !part.contains("[rig") && !part.contains("[contact")).collect();
    says(&told(&format!("{without}\n{rotor}"), &[]), &["[rig.rotor] without [stator]", "needs [stator]"]);
    // A stator by itself is a scene.
    let (bare, _) = USM.split_once("[rig.rotor]").unwrap();
    assert!(load_text("bare", bare, &[]).unwrap().scene.driven().unwrap().rotor().is_none());
}

#[test]
fn only_a_stator_has_lanes_that_differ() {
    let told = told(example(), &["amplifier.lane_gain_error=[0, 0.1]"]);
    says(&told, &["`amplifier.lane_gain_error` has no place beside [stack]", "belongs to [stator]", "1 problem"]);
}

#[test]
fn units_of_a_rotor_are_read() {
    says(&told(USM, &["rig.rotor.torque_nm=\"2\""]), &["a number in N m"]);
    says(&told(USM, &["rig.rotor.torque_mnm=2"]), &["did you mean `torque_nm`?"]);
}

#[test]
fn a_key_of_a_motor_can_be_disturbed() {
    let torque = ["disturbance.0.at_s=0.1", "disturbance.0.key=rig.rotor.torque_nm", "disturbance.0.to=1e-3"];
    assert!(load_text("usm", USM, &sets(&torque)).is_ok());
    let stack = ["disturbance.0.at_s=0.1", "disturbance.0.key=stack.bvd.q", "disturbance.0.to=50"];
    says(&told(USM, &stack), &["`stack.bvd.q` cannot change: the scene has no [stack]"]);
}
