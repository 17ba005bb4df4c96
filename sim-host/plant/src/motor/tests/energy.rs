//! Tests of the energy balance, of the sign of the friction's work, and of the step.

use super::*;

fn residual(sets: &[&str]) -> f64 {
    let mut bench = Bench::new(sets);
    bench.play(0.03);
    bench.volts = 0.0;
    bench.play(0.02);
    bench.motor.energy().residual()
}

#[test]
fn energy_closes() {
    for sets in [
        &[][..],
        &["rig.rotor.mu=0"],
        &["amplifier.lane_phase_error_deg=[0, 10, -5, 7]", "amplifier.lane_gain_error=[0, 0.06, -0.03, 0.04]"],
        &["stator.split_hz=100", "rig.rotor.torque_nm=8e-3"],
        &["disturbance.0.at_s=0.015", "disturbance.0.key=stator.series_resonance_hz", "disturbance.0.to=40100"],
        &["disturbance.0.at_s=0.01", "disturbance.0.key=stator.series_resonance_hz", "disturbance.0.rate_per_s=5e3"],
        &["disturbance.0.at_s=0.01", "disturbance.0.key=rig.rotor.preload_n", "disturbance.0.to=8"],
    ] {
        let left = residual(sets);
        assert!(left.abs() < 1e-4, "{sets:?}: {left:e}"); // 4e-5 measured
    }
}

/// Second order: half the step gives a quarter of the error, until only the converter's images
/// remain.
#[test]
fn the_answer_does_not_depend_on_the_step() {
    let speed = |steps: &str| {
        let errors = "amplifier.lane_phase_error_deg=[0, 10, -5, 7]";
        let truths = Bench::new(&[steps, errors]).play(0.03);
        mean(&truths, 500, |motor| motor.rotor_rad_per_s)
    };
    let (coarse, usual, fine) = (
        speed("integrator.steps_per_period=16"),
        speed("integrator.steps_per_period=32"),
        speed("integrator.steps_per_period=200"),
    );
    // Measured: 5.4e-4 and 1.3e-4.
    assert!((usual / fine - 1.0).abs() < 1.5e-4 && (coarse / fine - 1.0).abs() < 6e-4, "{coarse} {usual} {fine}");
}

#[test]
fn friction_only_dissipates() {
    let mut bench = Bench::new(&["amplifier.lane_phase_error_deg=[0, 10, -5, 7]"]);
    let mut truths = bench.play(0.02);
    bench.volts = 0.0;
    truths.extend(bench.play(0.005));
    let heat = |truth: &BlockTruth| truth.all.friction_on_tip_w + truth.all.friction_on_slider_w;
    let least = truths.iter().map(heat).fold(f64::INFINITY, f64::min);
    assert!(least > -1e-6, "{least}");
}
