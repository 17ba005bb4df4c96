//! Tests of the flow against formulas, and against finer steps.

use realfft::num_complex::Complex64;

use super::*;
use crate::breakage::Breakage;
use crate::circuit::Branch;
use crate::quad::Portable;

fn timing(step_s: f64) -> Timing {
    Timing { sample_s: step_s, steps: 1, conversions: 1, skew_s: 0.0 }
}

const A3: Circuit = Circuit { c0_f: 300e-9, cm_f: 20e-9, lm_h: 0.7916e-3, rm_ohm: 3.08, force_factor_n_per_v: 5.566 };

/// Drives with a sine sampled so finely that the hold has no effect, and compares with the
/// admittance.
#[test]
fn steady_state_is_the_admittance() {
    let amplifier = Amplifier { bandwidth_hz: 1e7, ..Amplifier::default() };
    let step = 1e-8;
    let hz = 40_100.0;
    let omega = std::f64::consts::TAU * hz;
    let mut stack = Stack::new(A3.into(), &amplifier, timing(step));
    let (mut re, mut im, mut vre, mut vim) = (0.0, 0.0, 0.0, 0.0);
    let settled = 1_000_000;
    let measured = 4 * 2494; // four periods, to a part in 2e5
    for n in 0..settled + measured {
        let t = n as f64 * step;
        stack.advance(&stack.held((omega * t).sin()), 0.0);
        if n >= settled {
            let (s, c) = (omega * t).sin_cos();
            (re, im) = (re + stack.current() * c, im - stack.current() * s);
            (vre, vim) = (vre + stack.voltage() * c, vim - stack.voltage() * s);
        }
    }
    let norm = vre * vre + vim * vim;
    let y = ((re * vre + im * vim) / norm, (im * vre - re * vim) / norm);
    let reactance = omega * A3.lm_h - 1.0 / (omega * A3.cm_f);
    let square = A3.rm_ohm.powi(2) + reactance.powi(2);
    let expected = (A3.rm_ohm / square, omega * A3.c0_f - reactance / square);
    assert!((y.0 - expected.0).abs() < 2e-4 && (y.1 - expected.1).abs() < 2e-4, "{y:?} {expected:?}");
}

#[test]
fn step_size_does_not_change_the_answer() {
    let mut coarse = Stack::new(A3.into(), &Amplifier::default(), timing(1e-6));
    let mut fine = Stack::new(A3.into(), &Amplifier::default(), timing(1e-7));
    for n in 0..5000 {
        let volts = if (n / 12) % 2 == 0 { 3.0 } else { -3.0 };
        coarse.advance(&coarse.held(volts), 0.2);
        (0..10).for_each(|_| fine.advance(&fine.held(volts), 0.2));
    }
    let scale = coarse.motional_current().abs().max(0.1);
    assert!((coarse.motional_current() - fine.motional_current()).abs() < 1e-10 * scale);
    assert!((coarse.voltage() - fine.voltage()).abs() < 1e-10);
}

/// Every conversion, at any division of the sample and any skew, equals a flow of 20 ns steps at
/// its time.
#[test]
fn conversions_lie_on_the_exact_flow() {
    for (steps, conversions, skew_s) in [(1, 2, 0.0), (2, 2, 80e-9), (3, 4, -60e-9), (1, 1, 100e-9), (6, 3, 240e-9)] {
        let divided = Timing { sample_s: 1.2e-6, steps, conversions, skew_s };
        let mut stack = Stack::new(A3.into(), &Amplifier::default(), divided);
        let mut fine = Stack::new(A3.into(), &Amplifier::default(), timing(20e-9));
        for volts in [2.5, -1.0, 3.0] {
            let (mut got, mut seen) = (Vec::new(), Vec::new());
            for step in 0..steps as usize {
                stack.advance(&stack.held(volts), 0.3);
                stack.sample(Portable, step, &stack.held(volts), 0.3, |seen, count| {
                    got.extend(seen.quad().0.chunks(2).take(count).map(|both| [both[0], both[1]]))
                });
            }
            for _ in 0..60 {
                fine.advance(&fine.held(volts), 0.3);
                seen.push((fine.voltage(), fine.current()));
            }
            let at = |time: f64| seen[(time / 20e-9).round() as usize - 1];
            for (k, [v, i]) in got.iter().enumerate() {
                let time = 1.2e-6 * (k + 1) as f64 / f64::from(conversions);
                let expected = (at(time - skew_s.max(0.0)).0, at(time + skew_s.min(0.0)).1);
                assert!((v - expected.0).abs() < 1e-9 && (i - expected.1).abs() < 1e-9, "{k}: {v} {i} {expected:?}");
            }
            assert_eq!(got.len(), conversions as usize);
        }
    }
}

/// The admittance of a stack with two further modes and a leak is the sum of its branches, near
/// each resonance and between.
#[test]
fn the_admittance_is_the_sum_of_the_branches() {
    let further = vec![Branch::new(39_400.0, 100.0, 4e-3), Branch::new(43_000.0, 50.0, 2.6e-3)];
    let parts = Parts { circuit: A3, leak_s: 0.02 * A3.omega() * A3.c0_f, further };
    let mut worst = 0.0f64;
    for hz in [38_000.0, 39_400.0, 40_000.0, 40_500.0, 41_400.0, 43_000.0, 60_000.0] {
        let (seen, expected) = (admittance(&parts, hz), formula(&parts, hz));
        worst = worst.max((seen - expected).norm() / expected.norm());
    }
    println!("admittance of three modes: {worst:.1e}");
    // Measured 2.1e-8.
    assert!(worst < 1e-7, "{worst:e}");
}

/// Returns current over voltage at `hz`, by a sine of 1000 steps a period after 800 periods.
fn admittance(parts: &Parts, hz: f64) -> Complex64 {
    const STEPS: usize = 1000;
    let amplifier = Amplifier { bandwidth_hz: 50e3, ..Amplifier::default() };
    let mut stack = Stack::new(parts.clone(), &amplifier, timing(1.0 / (hz * STEPS as f64)));
    let turn = |n: usize| Complex64::cis(std::f64::consts::TAU * (n % STEPS) as f64 / STEPS as f64);
    let (mut voltage, mut current) = (Complex64::ZERO, Complex64::ZERO);
    for n in 0..810 * STEPS {
        stack.advance(&stack.held(turn(n).im), 0.0);
        if n >= 800 * STEPS {
            (voltage, current) = (voltage + turn(n).conj() * stack.voltage(), current + turn(n).conj() * stack.current());
        }
    }
    current / voltage
}

fn formula(parts: &Parts, hz: f64) -> Complex64 {
    let omega = std::f64::consts::TAU * hz;
    let branch = |cm: f64, lm: f64, rm: f64| Complex64::new(rm, omega * lm - 1.0 / (omega * cm)).inv();
    let Circuit { c0_f, cm_f, lm_h, rm_ohm, .. } = parts.circuit;
    let first = Complex64::new(parts.leak_s, omega * c0_f) + branch(cm_f, lm_h, rm_ohm);
    parts.further.iter().fold(first, |sum, mode| sum + branch(mode.cm_f, mode.lm_h, mode.rm_ohm))
}

/// A drive that is late by a fraction of a sample, with further modes, several steps and several
/// conversions, equals a flow of 20 ns steps whose drive changes at the delayed time.
#[test]
fn a_late_drive_is_exact() {
    let further = vec![Branch::new(39_400.0, 100.0, 4e-3)];
    let parts = Parts { circuit: A3, leak_s: 1e-3, further };
    for (steps, conversions, skew_s, late) in [(1, 2, 0.0, 13), (2, 2, 80e-9, 41), (3, 4, -60e-9, 20), (1, 1, 100e-9, 57)] {
        let divided = Timing { sample_s: 1.2e-6, steps, conversions, skew_s };
        let mut stack = Stack::with_late_drive(parts.clone(), &Amplifier::default(), divided, 20e-9 * f64::from(late));
        let mut fine = Stack::new(parts.clone(), &Amplifier::default(), timing(20e-9));
        let mut before = 0.0;
        for volts in [2.5, -1.0, 3.0] {
            let (mut got, mut seen) = (Vec::new(), Vec::new());
            for step in 0..steps as usize {
                let held = stack.held_late(step, volts, before);
                stack.advance(&held, 0.3);
                stack.sample(Portable, step, &held, 0.3, |seen, count| {
                    got.extend(seen.quad().0.chunks(2).take(count).map(|both| [both[0], both[1]]))
                });
            }
            for n in 0..60 {
                fine.advance(&fine.held(if n < late { before } else { volts }), 0.3);
                seen.push((fine.voltage(), fine.current()));
            }
            before = volts;
            let at = |time: f64| seen[(time / 20e-9).round() as usize - 1];
            for (k, [v, i]) in got.iter().enumerate() {
                let time = 1.2e-6 * (k + 1) as f64 / f64::from(conversions);
                let expected = (at(time - skew_s.max(0.0)).0, at(time + skew_s.min(0.0)).1);
                assert!((v - expected.0).abs() < 1e-9 && (i - expected.1).abs() < 1e-9, "{k}: {v} {i} {expected:?}");
            }
            for (mine, other) in stack.further.iter().flatten().zip(fine.further.iter().flatten()) {
                assert!((mine - other).abs() < 1e-9, "{mine} {other}");
            }
        }
    }
}

/// A stack that loses its polarisation keeps the motion and the energy of every mode.
#[test]
fn motion_continues_when_the_coupling_changes() {
    let further = vec![Branch::new(39_400.0, 100.0, 4e-3)];
    let mut stack = Stack::new(Parts { circuit: A3, leak_s: 0.0, further }, &Amplifier::default(), timing(1e-6));
    (0..777).for_each(|n| stack.advance(&stack.held((0.2513 * f64::from(n)).sin()), 0.0));
    let before = (stack.stored_j(), stack.tip_velocity(), stack.tip_displacement());
    stack.set(Breakage::Depoled.apply(stack.parts().clone()));
    let after = (stack.stored_j(), stack.tip_velocity(), stack.tip_displacement());
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
    assert!(near(before.0, after.0) && near(before.1, after.1) && near(before.2, after.2), "{before:?} {after:?}");
}

/// A drift by the series equals one by an exponential in every block: one resonance, and everything
/// that temperature changes.
#[test]
fn the_series_gives_the_same_run() {
    let mut series = Stack::new(A3.into(), &Amplifier::default(), timing(1e-6));
    let mut exact = series.clone();
    let (mut worst, mut remade) = (0.0f64, 0);
    for n in 0..64_000 {
        if n % 32 == 0 {
            let s = 2.5e-7 * f64::from(n);
            let mut circuit = A3.with_series_resonance(A3.series_resonance_hz() * (1.0 - 0.5 * s));
            if n >= 32_000 {
                let warmth = 2.5e-7 * f64::from(n - 32_000);
                let factor = 1.0 - warmth;
                circuit.c0_f *= 1.0 + 2.0 * warmth;
                circuit.force_factor_n_per_v *= factor;
                circuit.lm_h /= factor * factor;
                circuit.rm_ohm *= (1.0 + 20.0 * warmth) / (factor * factor);
                circuit.cm_f *= factor * factor;
            }
            series.set(circuit.into());
            remade += u32::from(series.since == 0);
            exact.set(circuit.into());
            (exact.expansion, exact.since) = (None, 0);
        }
        let volts = 3.0 * (0.2513 * f64::from(n)).sin();
        for stack in [&mut series, &mut exact] {
            stack.advance(&stack.held(volts), 0.1);
        }
        worst = worst.max((series.voltage() - exact.voltage()).abs()).max((series.current() - exact.current()).abs());
    }
    println!("series against exponentials: {worst:e} V or A of 3 V, {remade} series");
    // Measured 2.4e-11 and 12.
    assert!(worst < 5e-11 && (2..20).contains(&remade), "{worst:e}, {remade}");
}
