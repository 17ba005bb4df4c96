//! Rotor speed against the closed forms.

use super::*;

/// Settling time, s: the time constant of the wave is 0.64 ms, and the rotor follows within a
/// millisecond.
const SETTLED_S: f64 = 0.03;
const LAST: usize = 100;

/// Returns the measured speed ratio, the closed form at the same amplitude and torque, and the
/// contact angle.
fn ratios(sets: &[&str]) -> (f64, f64, f64) {
    let mut bench = Bench::new(sets);
    let truths = bench.play(SETTLED_S);
    let speed = mean(&truths, LAST, |motor| motor.rotor_m_per_s) / mean(&truths, LAST, |motor| motor.forward_m_per_s);
    let scene = usm(sets);
    let rotor = scene.rig.unwrap().rotor.unwrap();
    let amplitude = mean(&truths, LAST, |motor| motor.forward_m);
    let steady = steady::Steady::new(amplitude, rotor.contact_stiffness_n_per_m, rotor.preload_n);
    let part = rotor.torque_nm / (rotor.radius_m * rotor.mu * rotor.preload_n);
    (speed, steady.speed_ratio(part), steady.zone().to_degrees())
}

#[test]
fn the_torque_speed_curve_is_the_closed_form() {
    for torque in [-6e-3, -2e-3, 0.0, 2e-3, 6e-3, 10e-3] {
        let (got, expected, _) = ratios(&[&format!("rig.rotor.torque_nm={torque}")]);
        assert!((got - expected).abs() < 2e-4, "{torque}: {got} {expected}");
    }
}

/// The table of no-load speeds, with layers that give the angles to within a degree.
#[test]
fn no_load_speeds_follow_the_contact_angle() {
    for stiffness in [4e9, 5e8, 1.5e8, 7e7] {
        let (got, expected, zone) =
            ratios(&["rig.rotor.torque_nm=0", &format!("rig.rotor.contact_stiffness_n_per_m={stiffness}")]);
        assert!((got - expected).abs() < 2e-4, "{zone} degrees: {got} {expected}");
        assert!((10.0..70.0).contains(&zone), "{zone}");
    }
}

#[test]
fn swapped_lanes_turn_the_other_way() {
    let mut forward = Bench::new(&["rig.rotor.torque_nm=0"]);
    let mut reverse = Bench::new(&["rig.rotor.torque_nm=0"]);
    reverse.turns.swap(1, 3);
    let speeds = [&mut forward, &mut reverse].map(|bench| mean(&bench.play(SETTLED_S), LAST, |motor| motor.rotor_rad_per_s));
    assert!(speeds[0] > 3.0 && (speeds[0] + speeds[1]).abs() < 1e-3 * speeds[0], "{speeds:?}");
}

/// A torque above that of the friction turns the rotor backwards; a smaller one is held without any
/// drive.
#[test]
fn at_standstill_the_preload_holds() {
    let holding = |torque: &str| {
        let mut bench = Bench::new(&[torque]);
        bench.volts = 0.0;
        mean(&bench.play(0.01), 1, |motor| motor.rotor_rad_per_s)
    };
    // mu N r = 11.6 mN m.
    assert_eq!(holding("rig.rotor.torque_nm=11.5e-3"), 0.0);
    assert!(holding("rig.rotor.torque_nm=11.7e-3") < -0.1);
}

/// After the drive the rotor stops exactly and remains at rest under its load.
#[test]
fn the_rotor_stops_after_the_drive() {
    let mut bench = Bench::new(&[]);
    bench.play(SETTLED_S);
    bench.volts = 0.0;
    let after = bench.play(0.02);
    let stopped = after.iter().position(|truth| truth.motor.rotor_rad_per_s == 0.0).map(|n| n as f64 * 0.032);
    assert!(stopped.is_some_and(|ms| (0.1..5.0).contains(&ms)), "{stopped:?}");
    assert_eq!(mean(&after, 100, |motor| motor.rotor_rad_per_s.abs()), 0.0);
}

#[test]
fn the_mean_normal_force_is_the_preload() {
    for sets in [&[][..], &["amplifier.lane_phase_error_deg=[0, 20, 0, 20]"]] {
        let mut bench = Bench::new(sets);
        let truths = bench.play(SETTLED_S);
        let normal = mean(&truths, 500, |motor| motor.normal_n);
        assert!((normal / 5.0 - 1.0).abs() < 2e-3, "{sets:?}: {normal}");
    }
}

/// A load that changes during the run leads to the speed for the new load.
#[test]
fn a_load_step_leads_to_the_new_speed() {
    let step = ["disturbance.0.at_s=0.01", "disturbance.0.key=rig.rotor.torque_nm", "disturbance.0.to=6e-3"];
    let speed = |sets: &[&str]| mean(&Bench::new(sets).play(SETTLED_S), LAST, |motor| motor.rotor_rad_per_s);
    let (stepped, steady) = (speed(&step), speed(&["rig.rotor.torque_nm=6e-3"]));
    assert!((stepped / steady - 1.0).abs() < 1e-6, "{stepped} {steady}");
}
