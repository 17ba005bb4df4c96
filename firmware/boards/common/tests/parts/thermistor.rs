//! Temperature measured by a thermistor.

use boards_common::thermistor::Thermistor;

/// The most common thermistor: 10 kOhm, pulled up by 10 kOhm, B 3950 K.
const THERMISTOR: Thermistor = Thermistor { ohm_at_25_c: 10e3, beta_k: 3950.0, pull_up_ohm: 10e3, codes: 4096.0 };

/// Micromath's logarithm in f32 costs 0.0027 K. A step of the converter is up to 0.6 K at the ends.
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
    // Shorted, nearly shorted, and open.
    assert_eq!([0, 1, 4095].map(|code| THERMISTOR.celsius(code)), [155.0; 3]);
}

#[test]
fn a_converter_of_more_bits_reads_the_same_temperature() {
    let sixteen = Thermistor { codes: 65536.0, ..THERMISTOR };
    for code in [400, 2048, 3600] {
        assert!((sixteen.celsius(16 * code) - THERMISTOR.celsius(code)).abs() < 1e-3, "{code}");
    }
}
