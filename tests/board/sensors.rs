//! Temperature of the processor, from the factory's calibration.

use nucleo_g474re::degrees::{Calibration, celsius};

/// Typical calibration at 3.0 V: 0.76 V at 30 degrees and 2.5 mV/K, the reference 1.212 V.
const CALIBRATION: Calibration = Calibration { low: 1037, high: 1379, reference: 1655 };

#[test]
fn degrees_are_those_of_the_calibration_at_any_supply() {
    let at = |sensor, reference| celsius(&CALIBRATION, sensor, reference);
    assert!((at(1037, 1655) - 30.0).abs() < 1e-3 && (at(1379, 1655) - 130.0).abs() < 1e-3);
    // At 3.3 V both codes are ten elevenths as large: a code is 0.32 K there, and the rounding of
    // either costs less.
    assert!((at(943, 1505) - 30.0).abs() < 0.3, "{}", at(943, 1505));
    assert!((at(1208, 1655) - 80.0).abs() < 1e-3);
}

#[test]
fn a_sensor_that_has_failed_counts_as_too_hot() {
    let uncalibrated = Calibration { low: 0xffff, high: 0xffff, reference: 0xffff };
    assert_eq!(celsius(&uncalibrated, 1000, 1500), 155.0);
    assert_eq!(
        [(0, 1655), (4095, 1655), (1037, 0)].map(|(sensor, reference)| celsius(&CALIBRATION, sensor, reference)),
        [155.0; 3]
    );
}
