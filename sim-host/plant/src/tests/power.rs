//! Tests of a stack at high power: a growing loss, heat, and the loss of polarisation.

use std::f64::consts::TAU;

use realfft::num_complex::Complex64;

use super::{Bench, scene};
use crate::circuit::Circuit;

/// Settings smooth enough that the images of the DAC's staircase do not affect a phasor of samples.
const SMOOTH: [&str; 2] = ["sensors.sample_hz=2e6", "amplifier.bandwidth_hz=50e3"];
const HEATING: [&str; 3] =
    ["stack.thermal.heat_capacity_j_per_k=0.02", "stack.thermal.resistance_k_per_w=20", "stack.thermal.curie_c=325"];

fn rest(loaded: &scene::load::Loaded) -> Circuit {
    Circuit::from_bvd(&loaded.scene.stack.as_ref().unwrap().bvd)
}

/// A loss that grows with amplitude matches its closed form: the amplitude `a` for which
/// `|Z(Rm(a))| a` is the played voltage. Off and at the resonance, for a law without a limit and
/// for one with a limit.
#[test]
fn growing_loss_matches_its_closed_form() {
    const PER_A2: f64 = 0.8;
    for (hz, volts, most) in [(40_000.0, 1.0, None), (40_000.0, 4.0, None), (40_250.0, 4.0, None), (40_000.0, 4.0, Some(1.5))] {
        let mut sets = vec!["stack.bvd.series_resonance_hz=40e3".to_owned(), format!("stack.bvd.amplitude_rm_per_a2={PER_A2}")];
        sets.extend(most.map(|most| format!("stack.bvd.amplitude_rm_most={most}")));
        let loaded = scene(&sets.iter().map(String::as_str).collect::<Vec<_>>());
        let (rest, source_ohm) = (rest(&loaded), loaded.scene.amplifier.as_ref().unwrap().source_ohm);
        let mut bench = Bench::new(&loaded);
        bench.sine(hz, volts, 40_000, |_| {});
        let (voltage, current) = bench.phasors(hz, volts, 20_000);
        let omega = TAU * hz;
        let total = current + voltage * Complex64::new(0.0, omega * rest.c0_f);
        let played_v = (voltage + total * source_ohm).norm();
        let raised = |a: f64| most.map_or(PER_A2 * a * a, |most: f64| PER_A2 * a * a / (1.0 + PER_A2 * a * a / (most - 1.0)));
        let needed_v = |a: f64| {
            let branch = Complex64::new(rest.rm_ohm * (1.0 + raised(a)), omega * rest.lm_h - 1.0 / (omega * rest.cm_f));
            a * (branch * Complex64::new(1.0, omega * source_ohm * rest.c0_f) + source_ohm).norm()
        };
        let (mut low, mut high) = (0.0, 3.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if needed_v(middle) < played_v { low = middle } else { high = middle }
        }
        let q = rest.q() / (1.0 + raised(low));
        println!("{hz} Hz {volts} V: {:.6} A of {low:.6}, Q {:.3} of {q:.3}", current.norm(), bench.plant.circuit().q());
        assert!((current.norm() / low - 1.0).abs() < 3e-4, "{hz} {volts}");
        assert!((bench.plant.circuit().q() / q - 1.0).abs() < 1e-3, "{hz} {volts}");
    }
}

/// The heating power is `Rm |Im|^2 / 2` plus `G |V|^2 / 2` by the phasors, and all heat is in the
/// body or has left it.
#[test]
fn losses_become_heat() {
    let sets = [
        &HEATING[..],
        &SMOOTH,
        &[
            "stack.bvd.loss_tangent=0.05",
            "stack.bvd.series_resonance_hz=40e3",
            "stack.mode.0.series_resonance_hz=43e3",
            "stack.mode.0.q=100",
            "stack.mode.0.lm_h=4e-3",
        ],
    ]
    .concat();
    let loaded = scene(&sets);
    let rest = rest(&loaded);
    let mut bench = Bench::new(&loaded);
    let (mut heating_j, mut left_j, mut before_k) = (0.0, 0.0, 0.0);
    let block_s = 16e-6;
    for _ in 0..12_500 {
        bench.sine(40e3, 3.0, 32, |_| {});
        let heat = bench.plant.truth().heat.unwrap();
        heating_j += heat.heating_w * block_s;
        // The mean of an exponential towards R P over the block.
        let (end_k, remains) = (20.0 * heat.heating_w, (-block_s / 0.4f64).exp());
        left_j += block_s / 20.0 * (end_k + (before_k - end_k) * (1.0 - remains) * 0.4 / block_s);
        before_k = heat.temperature_k;
    }
    let stored_j = 0.02 * before_k;
    println!("{heating_j:.6} J heat, {stored_j:.6} J in the body at {before_k:.3} K, {left_j:.6} J left");
    assert!(((stored_j + left_j) / heating_j - 1.0).abs() < 1e-9);
    let energy = bench.plant.energy();
    let (voltage, current) = bench.phasors(40e3, 3.0, 20_000);
    let leak_s = 0.05 * TAU * 40e3 * rest.c0_f;
    let second = Complex64::new(TAU * 43e3 * 4e-3 / 100.0, TAU * 40e3 * 4e-3 - (TAU * 43e3).powi(2) * 4e-3 / (TAU * 40e3));
    let further_w = 0.5 * second.re * (voltage / second).norm_sqr();
    let expected = 0.5 * rest.rm_ohm * current.norm_sqr() + 0.5 * leak_s * voltage.norm_sqr() + further_w;
    // A single block is not a whole number of periods.
    let mut mean_w = 0.0;
    for _ in 0..625 {
        bench.sine(40e3, 3.0, 32, |_| {});
        mean_w += bench.plant.truth().heat.unwrap().heating_w / 625.0;
    }
    println!("{mean_w:.6} W of {expected:.6} W, {further_w:.6} W of them in the second mode");
    assert!((mean_w / expected - 1.0).abs() < 1e-4, "{mean_w} {expected}");
    // The budget contains the losses in the branches, but not the leakage.
    let leaked_j = heating_j - energy.lost_j;
    let dielectric_w = 0.5 * leak_s * voltage.norm_sqr();
    assert!((leaked_j / (0.2 * dielectric_w) - 1.0).abs() < 0.02, "{leaked_j} {dielectric_w}");
}

/// Everything changes at once, and the energy balance of supply, losses, friction, stored energy
/// and changed elements still closes.
#[test]
fn energy_closes_while_the_stack_heats_itself() {
    let moving = [
        SMOOTH[0],
        SMOOTH[1],
        "stack.bvd.series_resonance_hz=40.2e3",
        "stack.bvd.loss_tangent=0.02",
        "stack.bvd.duffing_hz_per_a2=-300",
        "stack.bvd.amplitude_rm_per_a2=0.3",
        "stack.bvd.temperature_hz_per_k=-10",
        "stack.bvd.temperature_c0_per_k=0.003",
        "stack.bvd.temperature_rm_per_k=0.005",
        "stack.bvd.temperature_force_factor_per_k=-0.003",
        "stack.mode.0.series_resonance_hz=43e3",
        "stack.mode.0.q=100",
        "stack.mode.0.lm_h=4e-3",
        "stack.thermal.heat_capacity_j_per_k=2e-4",
        "stack.thermal.resistance_k_per_w=20",
        "stack.thermal.curie_c=325",
    ];
    let mut bench = Bench::new(&scene(&moving));
    bench.sine(40_000.0, 3.0, 100_000, |_| {});
    let (energy, heat) = (bench.plant.energy(), bench.plant.truth().heat.unwrap());
    println!(
        "residual {:e} of {:.3e} J, {:e} J by changes, {:.2} K",
        energy.residual(),
        energy.supplied_j,
        energy.disturbed_j,
        heat.temperature_k
    );
    assert!(energy.residual().abs() < 1e-4 && energy.disturbed_j != 0.0, "{energy:?}");
    assert!(heat.temperature_k > 10.0, "{heat:?}");
    assert_eq!(bench.plant.states(), 10);
}

/// At a constant voltage no gain is unstable. At the resonance the temperature tends to
/// `T = R V^2 / (2 Rm0 (1 + c T))`, one root of a quadratic, with a source resistance that is
/// negligible against Rm.
#[test]
fn constant_voltage_heats_to_the_closed_form() {
    const PER_K: f64 = 0.05;
    let sets = [
        &HEATING[..],
        &SMOOTH,
        &[
            "stack.bvd.series_resonance_hz=40e3",
            "stack.bvd.temperature_rm_per_k=0.05",
            "amplifier.source_ohm=0.001",
            "stack.thermal.heat_capacity_j_per_k=0.002",
        ],
    ]
    .concat();
    let loaded = scene(&sets);
    let rest = rest(&loaded);
    let mut bench = Bench::new(&loaded);
    bench.sine(40e3, 3.0, 800_000, |_| {});
    let (voltage, _) = bench.phasors(40e3, 3.0, 20_000);
    let cold_k = 20.0 * voltage.norm_sqr() / (2.0 * rest.rm_ohm);
    let end_k = ((1.0 + 4.0 * PER_K * cold_k).sqrt() - 1.0) / (2.0 * PER_K);
    let heat = bench.plant.truth().heat.unwrap();
    println!("{:.4} K of {end_k:.4} K", heat.temperature_k);
    // Measured 2e-5: blocks, and the remainder after ten time constants.
    assert!((heat.temperature_k / end_k - 1.0).abs() < 3e-4, "{} {end_k}", heat.temperature_k);
    let gain = PER_K * end_k / (1.0 + PER_K * end_k);
    // A block is not a whole number of periods, so its loss fluctuates: average over many.
    let mut mean = 0.0;
    for _ in 0..625 {
        bench.sine(40e3, 3.0, 32, |_| {});
        mean += bench.plant.truth().heat.unwrap().gain / 625.0;
    }
    assert!((mean / gain - 1.0).abs() < 1e-3, "{mean} {gain}");
}

/// A stack at its Curie point behaves as after the fault `depoled`, and cools.
#[test]
fn at_its_curie_point_a_stack_is_depoled() {
    let sets =
        [&HEATING[..], &["stack.thermal.curie_c=60", "stack.thermal.depoling_c=55", "stack.thermal.heat_capacity_j_per_k=1e-3"]]
            .concat();
    let loaded = scene(&sets);
    let rest = rest(&loaded);
    let mut bench = Bench::new(&loaded);
    let mut hottest_k = 0.0f64;
    for _ in 0..5_000 {
        bench.sine(rest.series_resonance_hz(), 6.0, 32, |_| {});
        hottest_k = hottest_k.max(bench.plant.truth().heat.unwrap().temperature_k);
    }
    let (heat, circuit) = (bench.plant.truth().heat.unwrap(), bench.plant.circuit());
    assert!(heat.depoled && (35.0..37.0).contains(&hottest_k) && heat.temperature_k < 10.0, "{heat:?} {hottest_k}");
    assert!((circuit.force_factor_n_per_v / rest.force_factor_n_per_v - 0.1).abs() < 1e-9, "{circuit:?}");
}

/// The surroundings warm the stack with its own time constant. It begins at their temperature.
#[test]
fn surroundings_warm_a_stack_slowly() {
    let step = [
        "stack.temperature_k=10",
        "disturbance.0.at_s=0",
        "disturbance.0.key=stack.temperature_k",
        "disturbance.0.to=50",
        "stack.bvd.temperature_hz_per_k=-10",
    ];
    let loaded = scene(&[&HEATING[..], &step].concat());
    let rest = rest(&loaded);
    let mut bench = Bench::new(&loaded);
    assert!((bench.plant.circuit().series_resonance_hz() - rest.series_resonance_hz() + 100.0).abs() < 1e-6);
    bench.play(&vec![32768; 400_000]);
    let expected = 50.0 - 40.0 * (-1f64).exp();
    let heat = bench.plant.truth().heat.unwrap();
    assert!((heat.temperature_k / expected - 1.0).abs() < 1e-6, "{heat:?}");
}
