//! Configuration of the board: it is valid, and its scales agree with its circuit.

use firmware::controller::Controller;
use nucleo_g474re::blocks::BLOCK;
use nucleo_g474re::config::{SILENCE, TRIP_A, config, range_a, trip_codes};

#[test]
fn a_controller_can_be_built_for_one_two_and_four_lanes() {
    for lanes in [1, 2, 4] {
        let mut config = config();
        config.lanes = lanes;
        let controller = Controller::build(&config).expect("a valid configuration");
        let silence = controller.silence();
        assert_eq!((silence.lanes.len(), silence.lanes[0].len()), (usize::from(lanes), BLOCK));
        assert!(silence.lanes.iter().flatten().all(|&code| code == SILENCE));
    }
}

#[test]
fn scales_are_those_of_the_circuit() {
    let front_end = config().front_end;
    // 3.3 V / 4096 = 0.806 mV per code of either converter, half of that for a sum of two.
    assert!((front_end.drive_volt_per_lsb - 8.057e-3).abs() < 1e-6, "{}", front_end.drive_volt_per_lsb);
    assert!((front_end.volt_per_lsb - 5.035e-3).abs() < 1e-6, "{}", front_end.volt_per_lsb);
    assert!((front_end.ampere_per_lsb - 1.0071e-3).abs() < 1e-7, "{}", front_end.ampere_per_lsb);
    assert_eq!((front_end.sense_mid_code, front_end.sense_max_code), (4096, 8190));
}

#[test]
fn the_comparators_act_between_limit_and_end_of_the_range() {
    let limits = config().limits;
    assert!(limits.current_a < TRIP_A && TRIP_A < range_a(), "{} {TRIP_A} {}", limits.current_a, range_a());
    let (upper, lower) = trip_codes(TRIP_A);
    // 3.5 A * 0.4 V/A = 1.4 V, 1737 codes, about mid-scale.
    assert_eq!((upper, lower), (3785, 310));
    assert_eq!(trip_codes(100.0), (4095, 0));
    let volts = config().front_end.drive_volt_per_lsb * f32::from(SILENCE);
    assert!(limits.voltage_v < volts, "{} {volts}", limits.voltage_v);
}
