//! Tests of further modes.

use super::{Bench, scene};

const MODES: [&str; 6] = [
    "stack.mode.0.series_resonance_hz=39400",
    "stack.mode.0.q=100",
    "stack.mode.0.lm_h=4e-3",
    "stack.mode.1.series_resonance_hz=43000",
    "stack.mode.1.q=50",
    "stack.mode.1.lm_h=2.6e-3",
];

#[test]
fn states_are_counted() {
    assert_eq!(Bench::new(&scene(&[])).plant.states(), 7);
    assert_eq!(Bench::new(&scene(&MODES)).plant.states(), 11);
    let mut cracked = Bench::new(&scene(&["fault.0.kind=cracked", "fault.0.at_s=0"]));
    cracked.sine(40e3, 3.0, 32, |_| {});
    assert_eq!(cracked.plant.states(), 9);
}

/// The energy budget of all modes closes, also while everything drifts and a part fails.
#[test]
fn energy_closes() {
    // Fine and smooth enough that the steps of the drive do not affect the sums over the samples.
    let smooth = ["sensors.sample_hz=2e6", "amplifier.bandwidth_hz=50e3"];
    let drifting = [
        "stack.bvd.loss_tangent=0.02",
        "stack.bvd.duffing_hz_per_a2=-900",
        "stack.bvd.temperature_hz_per_k=-10",
        "stack.bvd.temperature_c0_per_k=0.003",
        "amplifier.delay_s=1.3e-6",
        "disturbance.0.at_s=0.002",
        "disturbance.0.key=stack.temperature_k",
        "disturbance.0.rate_per_s=100",
        "disturbance.1.at_s=0.004",
        "disturbance.1.key=stack.mode.1.series_resonance_hz",
        "disturbance.1.rate_per_s=-2000",
        "fault.0.at_s=0.015",
        "fault.0.kind=cracked",
    ];
    for (name, sets) in [("modes", [&MODES[..], &smooth].concat()), ("all", [&MODES[..], &smooth, &drifting].concat())] {
        let mut bench = Bench::new(&scene(&sets));
        bench.sine(40_000.0, 3.0, 100_000, |_| {});
        let energy = bench.plant.energy();
        println!("{name}: residual {:e} of {:.3e} J", energy.residual(), energy.supplied_j);
        assert!(energy.residual().abs() < 1e-4, "{name}: {energy:?}");
    }
}
