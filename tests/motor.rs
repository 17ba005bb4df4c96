//! The four-phase motor with the real controller: its direction and speed, and its start and stop.

mod lanes;

use scene::load::load;
use sim::instruments::measure;
use sim::metrics::Metrics;
use sim::run::{Watch, run};

/// Returns the metrics of the scene `usm` with changes and without a load.
fn usm(changes: &[&str]) -> Metrics {
    let sets: Vec<String> = ["rig.rotor.torque_nm=0"].iter().chain(changes).map(|&set| set.to_owned()).collect();
    let scene = load("usm", &sets).unwrap_or_else(|error| panic!("{error}")).scene;
    let scene = scene.driven().unwrap();
    let metrics = measure(&scene, &run(&scene, Watch::default()).unwrap());
    assert_eq!(metrics.get("fault_code"), Some(0.0), "{changes:?}");
    metrics
}

fn speed(changes: &[&str]) -> f64 {
    usm(changes).get("rotor_speed_rad_per_s").unwrap()
}

#[test]
fn both_directions_have_the_same_speed() {
    let (forward, reverse) = (speed(&[]), speed(&["controller.phasing.direction=reverse"]));
    assert!(forward > 5.0 && (forward + reverse).abs() < 1e-4 * forward, "{forward} {reverse}");
}

/// Without a load the speed follows the wave, which is nearly proportional to the voltage: friction
/// costs the same speed at both.
#[test]
fn speed_by_amplitude() {
    let (whole, half) = (speed(&[]), speed(&["controller.drive.amplitude_v=5"]));
    assert!((half / whole - 0.5).abs() < 0.04, "{half} of {whole}");
}

/// Off resonance the wave is `1 / |1 + j 2 Q df / f|` of that at resonance. The friction of the
/// rotor widens this curve.
#[test]
fn speed_by_frequency() {
    let at = |hz: f64| speed(&[&format!("controller.drive.detune_hz={hz}")]);
    let (on, detuned, far) = (at(0.0), at(300.0), at(600.0));
    let expected = |hz: f64| 1.0 / (1.0 + (2.0 * 80.0 * hz / 40e3).powi(2)).sqrt();
    assert!(on > detuned && detuned > far, "{on} {detuned} {far}");
    assert!((detuned / on - expected(300.0)).abs() < 0.02 && (far / on - expected(600.0)).abs() < 0.021, "{on} {detuned} {far}");
    // The phase is still followed: the estimate of the resonance stays.
    let bias = usm(&["controller.drive.detune_hz=300"]).get("series_resonance_error_hz");
    // Remaining error of the scan, whose resonance bends under the rotor: 0.68 Hz.
    assert!(bias.is_some_and(|bias| bias.abs() < 0.75), "{bias:?}");
}

/// A quadrature below a quarter turn makes a mixture of a travelling and a standing wave: slower,
/// through zero, and in reverse.
#[test]
fn speed_by_phase() {
    let at = |turns: f64| speed(&[&format!("controller.phasing.quadrature_turns={turns}")]);
    let speeds: Vec<f64> = [-0.25, -0.125, 0.0, 0.125, 0.25].into_iter().map(at).collect();
    assert!(speeds.windows(2).all(|pair| pair[1] > pair[0]), "{speeds:?}");
    assert!(speeds[2].abs() < 1e-3 * speeds[4] && (speeds[1] + speeds[3]).abs() < 1e-3 * speeds[4], "{speeds:?}");
}

#[test]
fn it_starts_softly_and_stops_sooner_with_a_brake() {
    let time = |name: &str, changes: &[&str]| usm(changes).get(name).unwrap();
    let (hard, soft) = (&[][..], &["controller.burst.edge=soft", "controller.burst.edge_cycles=400"][..]);
    let (sudden, gentle) = (time("start_time_ms", hard), time("start_time_ms", soft));
    assert!(gentle > sudden + 6.0, "{sudden} ms and {gentle} ms");
    // The stator rings down within one or two periods of the brake; the rest of the stop depends on
    // the friction of the rotor.
    let (free, braked) = (time("stop_time_ms", hard), time("stop_time_ms", &["controller.burst.brake=true"]));
    assert!(braked < free - 0.9, "{free} ms and {braked} ms");
}
