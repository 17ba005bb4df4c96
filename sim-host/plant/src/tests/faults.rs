//! What breaks in a stack.

use super::{Bench, scene};
use crate::breakage::SHORT_OHM;

fn voltages(sets: &[&str]) -> Vec<f64> {
    let (mut bench, mut voltages) = (Bench::of(&scene(sets)), Vec::new());
    bench.sine(40_000.0, 3.0, 6400, |block| voltages.extend(block.iter().map(|sample| sample.voltage_v)));
    voltages
}

/// At 0 a fault has been so from the beginning: the run is that of a stack which is so. Later, all before is as it was.
#[test]
fn at_zero_it_has_been_so_from_the_beginning() {
    let of = |c0_f: f64, coupling: f64| {
        let elements = [("c0_f", c0_f), ("cm_f", 2e-8 * coupling), ("lm_h", 0.7916e-3 / coupling), ("rm_ohm", 3.08 / coupling)];
        elements.map(|(key, value)| format!("stack.bvd.{key}={value:e}"))
    };
    let with = |elements: &[String], more: &[&str]| {
        let sets: Vec<&str> = elements.iter().map(String::as_str).chain(more.iter().copied()).collect();
        voltages(&sets)
    };
    let (whole, depoled) = (of(3e-7, 1.0), of(2e-7, 0.01));
    let struck = |at_s: &str| with(&whole, &["fault.0.kind=depoled", &format!("fault.0.at_s={at_s}")]);
    let (so, at_zero, later) = (with(&depoled, &[]), struck("0"), struck("0.0033"));
    for (n, (got, expected)) in at_zero.iter().zip(&so).enumerate() {
        assert!((got - expected).abs() < 1e-12, "{n}: {got} {expected}");
    }
    // 3.3 ms falls into block 103, which begins with sample 3296.
    let before = with(&whole, &[]);
    assert_eq!(later[..3296], before[..3296]);
    assert!(later[3296..3328] != before[3296..3328]);
}

/// A short leaves the divider of its own resistance and the source's; the motional branch is 60 times the short.
#[test]
fn a_short_takes_the_voltage() {
    let shorted = voltages(&["fault.0.kind=short", "fault.0.at_s=0"]);
    let peak = shorted[3200..].iter().copied().fold(0.0, f64::max);
    let source = scene(&[]).scene.amplifier.unwrap().source_ohm;
    let expected = 3.0 * SHORT_OHM / (SHORT_OHM + source);
    println!("{peak} V of {expected} V");
    // Measured 0.9933 of it: the amplifier at 40 kHz, the hold, the branch beside.
    assert!((peak / expected - 1.0).abs() < 0.01, "{peak} {expected}");
}
