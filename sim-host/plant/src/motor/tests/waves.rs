//! Tests of the waves caused by lane errors against closed forms.

use super::*;

/// Settling time, s: the time constant at Q 80 is 0.64 ms.
const SETTLED_S: f64 = 0.02;
/// Settings without rotor friction, which acts on both modes and would couple them.
const BARE: [&str; 1] = ["rig.rotor.mu=0"];

fn backward(sets: &[&str]) -> f64 {
    let mut bench = Bench::new(&[&BARE[..], sets].concat());
    let truths = bench.play(SETTLED_S);
    mean(&truths, 25, |motor| motor.backward_m) / mean(&truths, 25, |motor| motor.forward_m)
}

#[test]
fn four_even_lanes_make_one_wave() {
    // The amplifiers are loaded equally, so only the rounding of the codes remains.
    assert!(backward(&[]) < 2e-5, "{:e}", backward(&[]));
}

/// Lanes 1 and 3 are late or early by eps: tan(eps / 2) in both cases.
#[test]
fn a_phase_error_makes_a_backward_wave_of_tan_half() {
    for degrees in [1.0f64, 5.0, 10.0, -10.0] {
        let set = format!("amplifier.lane_phase_error_deg=[0, {degrees}, 0, {degrees}]");
        let (got, expected) = (backward(&[&set]), (0.5 * degrees.to_radians()).tan().abs());
        assert!((got - expected).abs() < 3e-5, "{degrees}: {got} {expected}");
    }
}

/// Lanes 1 and 3 are larger by g: g / (2 + g).
#[test]
fn a_gain_error_makes_a_backward_wave_of_half() {
    for gain in [0.01, 0.1, -0.1] {
        let set = format!("amplifier.lane_gain_error=[0, {gain}, 0, {gain}]");
        let (got, expected) = (backward(&[&set]), f64::abs(gain / (2.0 + gain)));
        assert!((got - expected).abs() < 3e-5, "{gain}: {got} {expected}");
    }
}

/// Any four errors: each mode is driven by the sum of its two lanes.
#[test]
fn any_errors_make_the_wave_of_their_sums() {
    let (degrees, gains) = ([0.0f64, 10.0, -5.0, 7.0], [0.0, 0.06, -0.03, 0.04]);
    let lane = |lane: usize| {
        let (sin, cos) = degrees[lane].to_radians().sin_cos();
        ((1.0 + gains[lane]) * cos, (1.0 + gains[lane]) * sin)
    };
    let sum = |a: (f64, f64), b: (f64, f64)| (a.0 + b.0, a.1 + b.1);
    let (cosine, sine) = (sum(lane(0), lane(2)), sum(lane(1), lane(3)));
    let expected = (cosine.0 - sine.0).hypot(cosine.1 - sine.1) / (cosine.0 + sine.0).hypot(cosine.1 + sine.1);
    let got = backward(&["amplifier.lane_phase_error_deg=[0, 10, -5, 7]", "amplifier.lane_gain_error=[0, 0.06, -0.03, 0.04]"]);
    assert!((got - expected).abs() < 3e-5, "{got} {expected}");
}

/// Modes half a bandwidth apart have phases of +- atan(1 / 2) by their detuning.
#[test]
fn a_split_ring_has_a_backward_wave_without_any_lane_error() {
    // 250 Hz of 500 Hz bandwidth: each mode is detuned by a quarter of the bandwidth, so its phase
    // is atan(1 / 2).
    let got = backward(&["stator.split_hz=250"]);
    let expected = (0.5f64).atan().tan();
    assert!((got - expected).abs() < 0.005, "{got} {expected}");
}

/// The errors that the truth computes from codes are those of the scene.
#[test]
fn lane_errors_are_measured() {
    let mut bench =
        Bench::new(&["amplifier.lane_phase_error_deg=[2, 10, -5, 7]", "amplifier.lane_gain_error=[0, 0.06, -0.03, 0.04]"]);
    let truth = bench.play(SETTLED_S).pop().map(|truth| truth.motor).unwrap();
    let (phase, gain) = (truth.lane_phase_error_deg.unwrap(), truth.lane_gain_error_percent.unwrap());
    // Friction adds harmonics to the wave, and the block is not a whole number of periods: 2e-3
    // measured.
    assert!((phase - 8.0).abs() < 4e-3 && (gain - 6.0).abs() < 4e-3, "{phase} {gain}");
}
