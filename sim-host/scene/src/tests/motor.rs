//! Scenes with a motor: a stator instead of a stack, with or without a rotor.

use super::{example, says, sets};
use crate::load::load_text;

const USM: &str = include_str!("../../scenes/usm.toml");

fn problems_of(text: &str, changes: &[&str]) -> String {
    match load_text("usm.toml", text, &sets(changes)) {
        Ok(_) => panic!("there is no problem with {changes:?}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_stack_and_a_stator_exclude_each_other() {
    let stack = "[stack.bvd]\nc0_f = 3e-7\nseries_resonance_hz = 4e4\nq = 60\ncoupling = 0.25\n";
    says(
        &problems_of(&format!("{USM}\n{stack}"), &[]),
        &["[stack] and [stator] exclude each other", "is already given", "1 problem"],
    );
}

#[test]
fn stator_excludes_a_contact_and_rotor_needs_it() {
    let contact = ["contact.dahl.mu=0.2", "contact.dahl.stiffness_n_per_m=1e6"];
    says(&problems_of(USM, &contact), &["[contact] cannot be combined with [stator]", "[rig.rotor]", "1 problem"]);
    let rotor = "[rig.rotor]\ninertia_kg_m2 = 1e-6\npreload_n = 1\nmu = 0.2\nradius_m = 0.01\ncontact_stiffness_n_per_m = 1e7\n";
    let without: String =
        example().split_inclusive("\n\n").filter(|part| !part.contains("[rig") && !part.contains("[contact")).collect();
    says(&problems_of(&format!("{without}\n{rotor}"), &[]), &["[rig.rotor] without [stator]", "needs [stator]"]);
    // A stator without a rotor is a valid scene.
    let (bare, _) = USM.split_once("[rig.rotor]").unwrap();
    assert!(load_text("bare", bare, &[]).unwrap().scene.driven().unwrap().rotor().is_none());
}

#[test]
fn lane_errors_need_a_stator() {
    let problems = problems_of(example(), &["amplifier.lane_gain_error=[0, 0.1]"]);
    says(&problems, &["`amplifier.lane_gain_error` cannot be combined with [stack]", "belongs to [stator]", "1 problem"]);
}

#[test]
fn units_of_a_rotor_are_read() {
    says(&problems_of(USM, &["rig.rotor.torque_nm=\"2\""]), &["a number in N m"]);
    says(&problems_of(USM, &["rig.rotor.torque_mnm=2"]), &["did you mean `torque_nm`?"]);
}

#[test]
fn a_key_of_a_motor_can_be_disturbed() {
    let torque = ["disturbance.0.at_s=0.1", "disturbance.0.key=rig.rotor.torque_nm", "disturbance.0.to=1e-3"];
    assert!(load_text("usm", USM, &sets(&torque)).is_ok());
    let stack = ["disturbance.0.at_s=0.1", "disturbance.0.key=stack.bvd.q", "disturbance.0.to=50"];
    says(&problems_of(USM, &stack), &["`stack.bvd.q` cannot change: the scene has no [stack]"]);
}

#[test]
fn stack_only_keys_are_refused_with_a_stator() {
    says(&problems_of(USM, &["amplifier.delay_s=1e-6"]), &["`amplifier.delay_s` cannot be combined with [stator]", "1 problem"]);
    for kind in ["short", "depoled", "cracked"] {
        let fault = ["fault.0.at_s=0.1".to_owned(), format!("fault.0.kind={kind}")];
        let fault: Vec<&str> = fault.iter().map(String::as_str).collect();
        says(
            &problems_of(USM, &fault),
            &[&format!("a stator cannot have the fault `{kind}`"), "only for a [stack]", "1 problem"],
        );
    }
    for kind in ["swapped", "dropout", "open"] {
        let fault = ["fault.0.at_s=0.1".to_owned(), format!("fault.0.kind={kind}")];
        let fault: Vec<&str> = fault.iter().map(String::as_str).collect();
        assert!(load_text("usm", USM, &sets(&fault)).is_ok(), "{kind}");
    }
    let mode = ["disturbance.0.at_s=0.1", "disturbance.0.key=stack.mode.0.series_resonance_hz", "disturbance.0.to=5e4"];
    says(&problems_of(USM, &mode), &["cannot change: the scene has no [stack]"]);
    says(&problems_of(example(), &mode), &["cannot change: the scene has no [stack.mode]", "1 problem"]);
}

#[test]
fn lane_faults_need_their_lane() {
    let fault = |changes: &[&str]| {
        let keys: Vec<String> = changes.iter().map(|change| format!("fault.0.{change}")).collect();
        ["fault.0.at_s=0.1".to_owned()].into_iter().chain(keys).collect::<Vec<_>>()
    };
    let problems = |changes: &[&str]| {
        let fault = fault(changes);
        problems_of(USM, &fault.iter().map(String::as_str).collect::<Vec<_>>())
    };
    for changes in [
        &["kind=lane_open", "lane=0"][..],
        &["kind=lane_weak", "lane=1"],
        &["kind=lane_weak", "lane=1", "gain=0.3"],
        &["kind=lane_reversed", "lane=3"],
        &["kind=lanes_exchanged", "lane=1", "other_lane=2"],
    ] {
        assert!(load_text("usm", USM, &fault(changes)).is_ok(), "{changes:?}");
    }
    says(&problems(&["kind=lane_open"]), &["the fault `lane_open` needs `fault.0.lane`", "1 problem"]);
    says(&problems(&["kind=lanes_exchanged", "lane=1"]), &["needs `fault.0.other_lane`", "1 problem"]);
    says(&problems(&["kind=lanes_exchanged", "lane=1", "other_lane=1"]), &["exchanged with itself", "1 problem"]);
    says(&problems(&["kind=open", "ohm=3"]), &["`fault.0.ohm` cannot be used", "short", "1 problem"]);
    says(&problems(&["kind=lane_open", "lane=1", "gain=0.5"]), &["`fault.0.gain` cannot be used", "lane_weak", "1 problem"]);
    says(&problems(&["kind=open", "lane=1"]), &["`fault.0.lane` cannot be used with the fault `open`", "1 problem"]);
    says(&problems(&["kind=lane_open", "lane=4"]), &["must be from 0 to 3", "1 problem"]);
    let two = ["controller.drive.lanes=2", "fault.0.at_s=0.1", "fault.0.kind=lane_open", "fault.0.lane=2"];
    says(&problems_of(USM, &two), &["there is no lane 2", "must be less than 2", "1 problem"]);
    let stack = ["fault.0.at_s=0.1", "fault.0.kind=lane_weak", "fault.0.lane=0"];
    match load_text("example", example(), &sets(&stack)) {
        Ok(_) => panic!("a stack has no lanes"),
        Err(error) => says(&error.to_string(), &["cannot have `lane_weak`", "needs [stator]", "1 problem"]),
    }
}

#[test]
fn a_stack_with_everything_reads_back() {
    let changes = [
        "stack.temperature_k=12",
        "stack.bvd.temperature_hz_per_k=-10",
        "stack.bvd.temperature_c0_per_k=0.003",
        "stack.bvd.duffing_hz_per_a2=-900",
        "stack.bvd.loss_tangent=0.02",
        "stack.mode.0.series_resonance_hz=43e3",
        "stack.mode.0.q=50",
        "stack.mode.0.lm_h=4e-3",
        "amplifier.delay_s=1.3e-6",
        "disturbance.0.at_s=0.1",
        "disturbance.0.key=stack.mode.0.series_resonance_hz",
        "disturbance.0.rate_per_s=-1e3",
    ];
    let scene = load_text("all", example(), &sets(&changes)).unwrap().scene;
    let text = crate::resolved::resolved_toml(&scene);
    assert!(text.contains("[[stack.mode]]") && text.contains("temperature_k = 12.0"), "{text}");
    assert_eq!(load_text("all", &text, &[]).unwrap().scene, scene);
    says(&problems_of(example(), &["stack.bvd.duffing_hz_per_ma2=-1"]), &["did you mean `duffing_hz_per_a2`?"]);
}
