//! Random loads: a transducer of any Q is found in a wide or a narrow band, one outside the band is
//! said to be outside, and a diagnosis of the wiring is right.

use std::f64::consts::TAU;

use proptest::prelude::*;
use proptest::test_runner::{Config as Cases, RngSeed};

use super::field;
use crate::link::{board, run, session};
use link::answer::Answer;

/// Lowest frequency that the board measures, with a margin, Hz.
const MIN_HZ: f64 = 15.7e3;

/// Returns a configuration with this number of random cases, the same in every run.
fn cases(count: u32) -> Cases {
    Cases { cases: count, rng_seed: RngSeed::Fixed(1), failure_persistence: None, max_shrink_iters: 0, ..Cases::default() }
}

/// Returns a number between two ends, evenly distributed on a logarithmic scale.
fn log((from, to): (f64, f64)) -> impl Strategy<Value = f64> {
    (from.ln()..to.ln()).prop_map(f64::exp)
}

/// Returns resonance, Hz, Q, coupling and C0, F, of a transducer with a visible circle.
fn transducer() -> impl Strategy<Value = (f64, f64, f64, f64)> {
    let drawn = (log((17e3, 95e3)), log((20.0, 5000.0)), log((0.05, 0.5)), log((1e-9, 20e-9)));
    drawn.prop_filter("a weak resonance", |(_, q, k, _)| q * k * k > 2.0)
}

/// Commissions a load on a board whose ranges suit its admittance, S.
fn commissioned(load: &str, siemens: f64, (low_hz, high_hz): (f64, f64), knows_c0: bool) -> Result<Answer, String> {
    let range_a = [0.005, 0.05, 0.5].into_iter().find(|range| *range > 1.8 * siemens).unwrap_or(5.0);
    let sets = [
        format!("stack.bvd={{{load}}}"),
        format!("sensors.i_full_scale_a={range_a}"),
        format!("controller.limits.current_a={}", 0.9 * range_a),
        format!("controller.tracking.nominal_c0_f={}", if knows_c0 { "5e-9" } else { "none" }),
    ];
    let board = board("transducer-skymen-60w", &sets.each_ref().map(String::as_str), 1);
    let command = format!("commission --band {low_hz:.2}:{high_hz:.2} --max-volts 3");
    let answers = run(&command, &mut session(&board)).map_err(|error| format!("{load} {command}: {error}"))?;
    Ok(answers[0].1.clone())
}

/// Commissions a transducer in a band.
fn found((hz, q, k, c0_f): (f64, f64, f64, f64), band_hz: (f64, f64), knows_c0: bool) -> Result<Answer, String> {
    let (clamped, motional) = (TAU * hz * c0_f, TAU * hz * c0_f * k * k * q / (1.0 - k * k));
    let load = format!("series_resonance_hz={hz:.3},q={q:.3},coupling={k:.4},c0_f={c0_f:e}");
    commissioned(&load, motional.hypot(2.0 * clamped), band_hz, knows_c0)
}

/// Checks that a transducer is found, at a part of a band of three bandwidths or an octave.
fn check_found(of: (f64, f64, f64, f64), part: f64, octave: bool, knows_c0: bool) -> Result<(), TestCaseError> {
    let (hz, q, ..) = of;
    let width_hz = 3.0 * hz / q;
    let low_hz = if octave { hz / 2f64.powf(part) } else { hz - part * width_hz };
    let high_hz = if octave { 2.0 * low_hz } else { low_hz + width_hz };
    let answer = found(of, (low_hz.max(MIN_HZ), high_hz), knows_c0).map_err(TestCaseError::fail)?;
    prop_assert!((field(&answer, "series_resonance_hz") - hz).abs() < (0.005 * hz / q).max(1.0), "{:?}", answer);
    prop_assert!((field(&answer, "q") / q - 1.0).abs() < 0.05, "{:?}", answer);
    // The admittance circle of a sharp resonance takes some 50 ring-down times.
    prop_assert!(field(&answer, "board_s") < 4.0 + 50.0 * q / (0.5 * TAU * hz), "{:?}", answer);
    Ok(())
}

/// Checks that a transducer in a distance from a band is said to be outside.
fn check_outside(of: (f64, f64, f64, f64), bandwidths: f64, above: bool, knows_c0: bool) -> Result<(), TestCaseError> {
    let (hz, q, ..) = of;
    let (apart_hz, width_hz) = ((bandwidths * hz / q).min(0.1 * hz), 3.0 * hz / q);
    let low_hz = if above { hz + apart_hz } else { hz - apart_hz - width_hz };
    prop_assume!(low_hz > MIN_HZ);
    let error = found(of, (low_hz, low_hz + width_hz), knows_c0).map(|answer| answer.text);
    prop_assert!(matches!(&error, Err(error) if error.contains("outside the band")), "{:?}", error);
    Ok(())
}

/// Checks the diagnosis of a resistor, a capacitor, nothing, or a short.
fn check_named(kind: usize, hz: f64, ohm: f64, ratio: f64, knows_c0: bool) -> Result<(), TestCaseError> {
    let far = "series_resonance_hz=300e3,q=50,coupling=0.0005";
    let (load, name, siemens) = match kind {
        0 => (format!("c0_f=1e-11,cm_f=1e-3,lm_h=1e-9,rm_ohm={ohm}"), "a resistor of", 1.0 / ohm),
        1 => (format!("c0_f={:e},{far}", 1.0 / (TAU * hz * ohm)), "a capacitor of", 1.0 / ohm),
        2 => (format!("c0_f=1e-13,{far}"), "no transducer", 0.0),
        _ => ("c0_f=1e-9,cm_f=1e-3,lm_h=1e-9,rm_ohm=0.02".into(), "a short", 1.0),
    };
    let error = commissioned(&load, siemens, (hz / ratio.sqrt(), hz * ratio.sqrt()), knows_c0).map(|answer| answer.text);
    prop_assert!(matches!(&error, Err(error) if error.contains(name)), "{}: {:?}", name, error);
    Ok(())
}

proptest! {
    #![proptest_config(cases(10))]

    #[test]
    fn a_drawn_transducer_is_found(of in transducer(), part in 0.02..0.98, octave: bool, knows_c0: bool) {
        check_found(of, part, octave, knows_c0)?;
    }

    #[test]
    fn a_drawn_transducer_is_outside(of in transducer(), bandwidths in 1.0..10.0, above: bool, knows_c0: bool) {
        check_outside(of, bandwidths, above, knows_c0)?;
    }
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn a_drawn_load_is_named(
        kind in 0_usize..4,
        hz in log((23e3, 80e3)),
        ohm in log((1.0, 9e3)),
        ratio in 1.001..1.9,
        knows_c0: bool,
    ) {
        check_named(kind, hz, ohm, ratio, knows_c0)?;
    }
}
