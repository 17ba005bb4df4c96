//! Tests of a late drive.

use super::{Bench, scene};

fn voltages(delay_s: f64, samples: usize) -> Vec<f64> {
    let mut bench = Bench::new(&scene(&[&format!("amplifier.delay_s={delay_s:e}"), "stack.bvd.loss_tangent=0.02"]));
    let mut voltages = Vec::new();
    bench.sine(40_123.0, 3.0, samples, |block| voltages.extend(block.iter().map(|sample| sample.voltage_v)));
    voltages
}

/// Three samples late is the same run three samples later, bit for bit.
#[test]
fn whole_samples_shift_the_run() {
    let (prompt, late) = (voltages(0.0, 640), voltages(3e-6, 640));
    assert_eq!(late[..3], [0.0; 3]);
    assert_eq!(late[3..], prompt[..637]);
}

/// The motional current, which does not respond to the images of the hold, is late by the delay for
/// any fraction of a sample.
#[test]
fn a_fraction_turns_the_phase() {
    let phasor = |delay_s: f64| {
        let mut bench = Bench::new(&scene(&[&format!("amplifier.delay_s={delay_s:e}")]));
        bench.sine(40_000.0, 3.0, 25 * 1600, |_| {});
        bench.phasors(40_000.0, 3.0, 25 * 32).1
    };
    let prompt = phasor(0.0);
    for delay_s in [0.37e-6, 2.81e-6] {
        let late_s = -(phasor(delay_s) / prompt).arg() / std::f64::consts::TAU / 40_000.0;
        println!("late by {delay_s:e} s: {:.2} ns more", (late_s - delay_s) * 1e9);
        // Measured 0.02 ns: the codes are rounded.
        assert!((late_s - delay_s).abs() < 5e-11, "{late_s:e}");
    }
}
