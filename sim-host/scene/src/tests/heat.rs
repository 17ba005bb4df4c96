//! Stacks at high power: limits and their messages.

use super::{example, loaded, report, says, sets};
use crate::load::load_text;

const BODY: [&str; 3] =
    ["stack.thermal.heat_capacity_j_per_k=0.05", "stack.thermal.resistance_k_per_w=20", "stack.thermal.curie_c=325"];

fn with_a_body(changes: &[&str]) -> Vec<String> {
    sets(&[&BODY[..], changes].concat())
}

fn problems_of(changes: &[&str]) -> String {
    match load_text("example", example(), &with_a_body(changes)) {
        Ok(_) => panic!("there is no problem with {changes:?}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn thermal_body_needs_capacity_and_resistance() {
    says(
        &problems_of(&["stack.thermal.heat_capacity_j_per_k=0"]),
        &["must be from 1e-6 to 1e6 J/K", "Heat capacity of the heated body", "1 problem"],
    );
    says(&problems_of(&["stack.thermal.resistance_k_per_w=-3"]), &["must be from 1e-6 to 1e6 K/W", "1 problem"]);
    says(&problems_of(&["stack.thermal.heating_fraction=1.2"]), &["must be from 0 to 1", "1 problem"]);
    says(
        &report(example(), &["stack.thermal.heat_capacity_j_per_k=0.05"]),
        &["`resistance_k_per_w` is missing in [stack.thermal]", "`curie_c` is missing in [stack.thermal]", "2 problems"],
    );
}

#[test]
fn energy_balance_needs_both_values() {
    let given = ["controller.thermometer.resistance_k_per_w=20"];
    says(&report(example(), &given), &["needs the heat capacity", "controller.thermometer.heat_capacity_j_per_k", "1 problem"]);
    assert!(load_text("example", example(), &sets(&[given[0], "controller.thermometer.heat_capacity_j_per_k=0.05"])).is_ok());
}

#[test]
fn initial_temperature_must_be_below_depoling() {
    says(
        &problems_of(&["stack.temperature_k=310"]),
        &[
            "310 K over ambient are 335 °C, above the Curie point of 325 °C",
            "must be less than 137.5 K",
            "`depoled`",
            "1 problem",
        ],
    );
    says(
        &problems_of(&["stack.temperature_k=140"]),
        &["140 K over ambient are 165 °C, above 162.5 °C: the stack slowly loses its polarisation", "1 problem"],
    );
    says(&problems_of(&["stack.thermal.ambient_c=200"]), &["0 K over ambient are 200 °C", "allows only -37.5 K", "1 problem"]);
    let step = ["disturbance.0.at_s=1", "disturbance.0.key=stack.temperature_k", "disturbance.0.to=400"];
    says(&problems_of(&step), &["400 K over ambient are 425 °C", "must be less than 137.5 K", "1 problem"]);
    says(
        &problems_of(&["stack.thermal.depoling_c=400"]),
        &["an operating temperature of 400 °C is above the Curie point of 325 °C", "must be at most 325", "1 problem"],
    );
    assert!(load_text("example", example(), &with_a_body(&["stack.thermal.depoling_c=325", "stack.temperature_k=299"])).is_ok());
}

#[test]
fn laws_are_checked_at_largest_current_and_heat() {
    says(
        &problems_of(&["stack.bvd.amplitude_rm_per_a2=-0.2"]),
        &[
            "at 3 A, the largest current (`controller.limits.current_a`)",
            "by -0.8: Q would be negative",
            "must be from -0.1 to 1 1/A^2",
            "1 problem",
        ],
    );
    says(
        &problems_of(&["stack.bvd.amplitude_rm_per_a2=2"]),
        &["multiplies the motional resistance by 19", "amplitude_rm_most", "1 problem"],
    );
    says(
        &problems_of(&["stack.bvd.amplitude_rm_per_a2=2", "sensors.i_full_scale_a=2.5", "controller.limits.current_a=4"]),
        &["at 2.5 A, the largest current (`sensors.i_full_scale_a`)"],
    );
    says(
        &problems_of(&["stack.bvd.amplitude_rm_most=3"]),
        &["limits a rise", "needs an `amplitude_rm_per_a2` above zero", "1 problem"],
    );
    says(
        &problems_of(&["stack.bvd.temperature_rm_per_k=-0.01"]),
        &[
            "at 137.5 K over ambient, the law multiplies the motional resistance by -0.375",
            "must be at least -0.00654545 1/K",
            "1 problem",
        ],
    );
    says(
        &report(example(), &["stack.bvd.temperature_force_factor_per_k=0.1", "stack.temperature_k=100"]),
        &["at 100 K over ambient, the law multiplies the force factor by 11", "must be at most 0.09 1/K", "1 problem"],
    );
}

/// The scene is restored from its own text, and keys with default values are not written.
#[test]
fn a_stack_at_power_reads_back() {
    let changes =
        ["stack.bvd.amplitude_rm_per_a2=2", "stack.bvd.amplitude_rm_most=3", "stack.bvd.temperature_force_factor_per_k=-1e-3"];
    let scene = load_text("power", example(), &with_a_body(&changes)).unwrap_or_else(|error| panic!("{error}")).scene;
    let text = crate::resolved::resolved_toml(&scene);
    assert!(text.contains("[stack.thermal]") && text.contains("amplitude_rm_most = 3.0"), "{text}");
    assert_eq!(load_text("power", &text, &[]).unwrap_or_else(|error| panic!("{error}")).scene, scene);
    let plain = crate::resolved::resolved_toml(&loaded(&[]));
    assert!(!plain.contains("\n[stack.thermal]") && !plain.contains("_rm_"), "{plain}");
}

#[test]
fn resistance_laws_are_refused_with_a_belt() {
    let belt = include_str!("../../scenes/experiment-2.toml");
    says(
        &report(belt, &["stack.bvd.temperature_rm_per_k=0.001"]),
        &["cannot be combined with [rig.belt]", "would also change the belt's damping", "1 problem"],
    );
}
