//! The slow sensors: degrees from the factory's calibration and from a thermistor, and the wires of the encoder.

use nucleo_g474re::degrees::{Calibration, Thermistor, celsius};
use nucleo_g474re::wires::Wires;

/// Typical of the part: 0.76 V at 30 degrees and 2.5 mV/K, the reference 1.212 V, at 3.0 V.
const CALIBRATION: Calibration = Calibration { low: 1037, high: 1379, reference: 1655 };

#[test]
fn degrees_are_those_of_the_calibration_at_any_supply() {
    let at = |sensor, reference| celsius(&CALIBRATION, sensor, reference).expect("plausible");
    assert!((at(1037, 1655) - 30.0).abs() < 1e-3 && (at(1379, 1655) - 130.0).abs() < 1e-3);
    // At 3.3 V both read ten elevenths: a code is 0.32 K there, and a rounding of either less than that.
    assert!((at(943, 1505) - 30.0).abs() < 0.3, "{}", at(943, 1505));
    assert!((at(1208, 1655) - 80.0).abs() < 1e-3);
}

#[test]
fn a_sensor_that_has_failed_has_no_temperature() {
    let uncalibrated = Calibration { low: 0xffff, high: 0xffff, reference: 0xffff };
    assert_eq!(celsius(&uncalibrated, 1000, 1500), None);
    assert_eq!(
        [(0, 1655), (4095, 1655), (1037, 0)].map(|(sensor, reference)| celsius(&CALIBRATION, sensor, reference)),
        [None; 3]
    );
}

/// 10 kOhm below 10 kOhm, B 3950 K: the most common one.
const THERMISTOR: Thermistor = Thermistor { ohm_at_25_c: 10e3, beta_k: 3950.0, pull_up_ohm: 10e3 };

/// The logarithm is micromath's, in f32: 0.0027 K. A step of the converter is up to 0.6 K at the ends.
#[test]
fn a_thermistor_is_read_within_milli_kelvins() {
    let exact = |code: u16| {
        let ratio = f64::from(code) / (4096.0 - f64::from(code));
        1.0 / (1.0 / 298.15 + ratio.ln() / 3950.0) - 273.15
    };
    let valid = (1..4096).filter(|&code| (-40.0..150.0).contains(&exact(code)));
    let worst = valid.map(|code| (f64::from(THERMISTOR.celsius(code)) - exact(code)).abs()).fold(0.0, f64::max);
    println!("{worst:.4} K");
    assert!(worst < 0.004, "{worst}");
    assert!((THERMISTOR.celsius(2048) - 25.0).abs() < 0.01);
}

#[test]
fn a_broken_thermistor_counts_as_too_hot() {
    // Short, open, and beyond what a converter has.
    assert_eq!([0, 1, 4095].map(|code| THERMISTOR.celsius(code)), [155.0; 3]);
}

/// Looks at wires over so many blocks; a channel's period is so many blocks, and what is broken is low.
fn looks(period: usize, blocks: usize, broken: [bool; 4]) -> Option<usize> {
    let mut wires = Wires::default();
    (0..blocks).find(|&block| {
        let high = |quarter: usize| (4 * block / period + quarter) % 4 < 2;
        let [a, b] = [high(0), high(1)];
        let [a, not_a, b, not_b] = core::array::from_fn(|n| [a, !a, b, !b][n] && !broken[n]);
        wires.look([(a, not_a), (b, not_b)])
    })
}

#[test]
fn a_broken_wire_is_found_in_motion_and_two_even_at_rest() {
    for wire in 0..4 {
        let broken = core::array::from_fn(|n| n == wire);
        // Within a period, however long, and within 24 blocks of a period of four.
        for period in [4, 40, 400] {
            let found = looks(period, 2 * period + 24, broken);
            assert!(found.is_some(), "wire {wire}, period {period}");
        }
    }
    assert_eq!(looks(1_000_000, 100, [true, true, false, false]), Some(2));
}

#[test]
fn whole_wires_are_never_broken_even_if_read_on_an_edge() {
    assert_eq!(looks(4, 1000, [false; 4]), None);
    assert_eq!(looks(400, 1000, [false; 4]), None);
    let mut wires = Wires::default();
    let glitches = |block: usize| block.is_multiple_of(5);
    assert!((0..1000).all(|block| !wires.look([(true, glitches(block)), (false, true)])));
}

#[test]
fn a_line_that_is_mended_is_trusted_again_but_not_at_once() {
    let mut wires = Wires::default();
    assert!((0..20).fold(false, |_, _| wires.look([(false, false), (true, false)])));
    let sound = (0..100).position(|_| !wires.look([(true, false), (true, false)]));
    assert_eq!(sound, Some(23));
}
