//! Tests of the estimator with stacks that settle immediately.

use super::*;
use crate::seam::phasor::magnitude;

const NOMINAL_HZ: f32 = 40e3;
const TAU: f32 = core::f32::consts::TAU;

/// Computes the admittance of a stack with the nominal resonance, rotated by `turn` in sensing.
fn admittance(c0_f: f32, q: f32, hz: f32, turn: f32) -> Phasor {
    let u = hz / NOMINAL_HZ;
    let conductance = 20e-9 * TAU * NOMINAL_HZ * q;
    let branch = Phasor::new(conductance, 0.0) / Phasor::new(1.0, q * (u - 1.0 / u));
    (branch + Phasor::new(0.0, TAU * hz * c0_f)) * Phasor::new(libm::cosf(turn), libm::sinf(turn))
}

/// Runs an estimator with a nominal 300 nF until its first update, on a stack with `c0_f` that is
/// driven `detuning` half bandwidths off resonance.
fn first_update(c0_f: f32, q: f32, detuning: f32, turn: f32) -> (Update, Motional, u32) {
    let axis = Phasor::new(libm::cosf(turn), libm::sinf(turn));
    let prior = Motional { y0: axis * Phasor::new(0.0, TAU * NOMINAL_HZ * 300e-9), axis };
    let mut online = Online::new(32e-6, prior, NOMINAL_HZ, q, 0.1);
    let mut detunes = [0.0; LATENCY_BLOCKS];
    for block in 0..5000_u32 {
        let detune_hz = detunes[block as usize % LATENCY_BLOCKS];
        let hz = NOMINAL_HZ + detuning * 0.5 * NOMINAL_HZ / q + detune_hz;
        let noise = if block % 2 == 0 { 1e-4 } else { -1e-4 };
        let i = admittance(c0_f, q, hz, turn) * 3.0 + Phasor::new(noise, -noise);
        let sensed = Sensed { v: Phasor::new(3.0, 0.0), i };
        let output = online.step(&Sample { sensed: &sensed, relative: hz / NOMINAL_HZ, detune_hz, volts: 3.0, steady: true });
        if let Some(update) = output.update {
            return (update, online.motional(), block);
        }
        detunes[block as usize % LATENCY_BLOCKS] = output.detune_hz;
    }
    panic!("no update");
}

#[test]
fn finds_the_capacitance_off_the_lock_point_and_with_skew() {
    for (c0_f, q, detuning, turn) in [(300e-9, 20.0, 0.0, 0.0), (315e-9, 20.0, 0.05, 0.0), (288e-9, 65.0, -0.05, 0.02)] {
        let (update, found, blocks) = first_update(c0_f, q, detuning, turn);
        let error = magnitude(found.y0) / (TAU * NOMINAL_HZ * c0_f) - 1.0;
        // Measured: 1.5e-4, the weight of the prior.
        assert!(error.abs() < 4e-4, "{c0_f} {q}: {error} after {blocks} blocks");
        // The correction for incomplete settling is added, although this stack settles immediately.
        let q_error = f64::from(update.q.value / q - 1.0);
        assert!((0.0..0.011).contains(&q_error) && update.q.deviation < 2e-3 * q, "{q}: {q_error} {:?}", update.q);
    }
}

#[test]
fn no_round_if_unsteady_or_already_accurate() {
    let prior = Motional::of_capacitance(300e-9, NOMINAL_HZ);
    let mut online = Online::new(32e-6, prior, NOMINAL_HZ, 20.0, 0.1);
    let sensed = Sensed { v: Phasor::new(3.0, 0.0), i: admittance(300e-9, 20.0, NOMINAL_HZ, 0.0) * 3.0 };
    let sample = Sample { sensed: &sensed, relative: 1.0, detune_hz: 0.0, volts: 3.0, steady: false };
    assert_eq!(online.step(&sample).detune_hz, 0.0);
    online.seed(prior, 1e-5, NOMINAL_HZ, 20.0);
    assert_eq!(online.step(&Sample { steady: true, ..sample }).detune_hz, 0.0);
    let rounds = (0..30_000).filter(|_| online.step(&Sample { steady: true, ..sample }).detune_hz != 0.0).count();
    assert!(rounds > 0, "no further round");
    // Every step of the drive interrupts a round.
    let stepped = (0..30_000).filter(|n| {
        let volts = if n % 100 < 50 { 3.0 } else { 2.0 };
        online.step(&Sample { steady: true, volts, ..sample }).update.is_some()
    });
    assert_eq!(stepped.count(), 0);
}

/// A drive that is steady for hardly longer than a round, or only every second time, is measured
/// now and then.
#[test]
fn interrupted_rounds_do_not_end_the_measurement() {
    for (first, second) in [(165, 165), (180, 180), (250, 250), (320, 320), (100, 200), (60, 220), (100, 220)] {
        let mut online = Online::new(32e-6, Motional::of_capacitance(300e-9, NOMINAL_HZ), NOMINAL_HZ, 20.0, 0.1);
        let mut detunes = [0.0; LATENCY_BLOCKS];
        let updates = (0..12 * (first + second)).filter(|&block| {
            let detune_hz = core::mem::take(&mut detunes[block % LATENCY_BLOCKS]);
            let hz = NOMINAL_HZ + detune_hz;
            let volts = if block % (first + second) < first { 3.0 } else { 2.0 };
            let noise = if block % 2 == 0 { 1e-4 } else { -1e-4 };
            let i = admittance(300e-9, 20.0, hz, 0.0) * volts + Phasor::new(noise, -noise);
            let sensed = Sensed { v: Phasor::new(volts, 0.0), i };
            let sample = Sample { sensed: &sensed, relative: hz / NOMINAL_HZ, detune_hz, volts, steady: true };
            let output = online.step(&sample);
            detunes[block % LATENCY_BLOCKS] = output.detune_hz;
            output.update.is_some()
        });
        let count = updates.count();
        assert!(count >= 3, "{first} and {second} blocks: {count}");
    }
}

#[test]
fn c0_drifts_in_a_pause_until_the_next_seed() {
    let prior = Motional::of_capacitance(300e-9, NOMINAL_HZ);
    let mut online = Online::new(32e-6, prior, NOMINAL_HZ, 20.0, 3e-4);
    online.seed(prior, 1e-4, NOMINAL_HZ, 20.0);
    // 64 s.
    (0..2_000_000).for_each(|_| online.rest());
    assert!((online.deviation() / 0.0192 - 1.0).abs() < 1e-3, "{}", online.deviation());
    online.seed(prior, 1e-4, NOMINAL_HZ, 20.0);
    assert!((online.deviation() / 1e-4 - 1.0).abs() < 1e-3, "{}", online.deviation());
}

/// Drives an estimator on a stack of Q 20 by its own detunes. `before` is called before each block
/// and returns `true` if the drive is steady.
fn drive(online: &mut Online, blocks: usize, noise_a: f32, mut before: impl FnMut(&mut Online) -> bool) -> (usize, usize) {
    let (mut detunes, mut probing, mut updates) = ([0.0; LATENCY_BLOCKS], 0, 0);
    for block in 0..blocks {
        let steady = before(online);
        let detune_hz = core::mem::take(&mut detunes[block % LATENCY_BLOCKS]);
        if !online.listens(true, false) {
            continue;
        }
        let (hz, noise) = (NOMINAL_HZ + detune_hz, if block % 2 == 0 { noise_a } else { -noise_a });
        let i = admittance(300e-9, 20.0, hz, 0.0) * 3.0 + Phasor::new(noise, -noise);
        let sensed = Sensed { v: Phasor::new(3.0, 0.0), i };
        let output = online.step(&Sample { sensed: &sensed, relative: hz / NOMINAL_HZ, detune_hz, volts: 3.0, steady });
        detunes[block % LATENCY_BLOCKS] = output.detune_hz;
        (probing, updates) = (probing + usize::from(online.probes()), updates + usize::from(output.update.is_some()));
    }
    (probing, updates)
}

/// A round too noisy for the target deviation is not repeated, unless C0 may drift.
#[test]
fn rounds_follow_each_other_only_if_c0_drifts() {
    for (drift_per_s, repeats) in [(0.0, false), (0.1, true)] {
        let prior = Motional::of_capacitance(300e-9, NOMINAL_HZ);
        let mut online = Online::new(32e-6, prior, NOMINAL_HZ, 20.0, drift_per_s);
        online.seed(prior, 0.02, NOMINAL_HZ, 20.0);
        let (_, updates) = drive(&mut online, 400, 0.1, |_| true);
        assert!(updates > 0 && online.deviation() > TARGET_DEVIATION_REL, "{updates} {}", online.deviation());
        let (probing, _) = drive(&mut online, 2000, 0.1, |_| true);
        assert_eq!(probing > 0, repeats, "{drift_per_s}: {probing}");
    }
}

/// An evaluation ends although the drive ends with the last measured block, or the resonance, and
/// with it the length of a round, changes.
#[test]
fn an_evaluation_is_never_lost() {
    for (steady, q) in [(true, 20.0), (false, 20.0), (true, 80.0), (false, 80.0), (true, 5.0)] {
        let prior = Motional::of_capacitance(300e-9, NOMINAL_HZ);
        let mut online = Online::new(32e-6, prior, NOMINAL_HZ, 20.0, 0.0);
        let (probing, updates) = drive(&mut online, 400, 1e-4, |online| {
            let evaluates = !matches!(online.evaluation, Evaluation::Measuring(_));
            if evaluates {
                online.set_resonance(NOMINAL_HZ, q);
            }
            steady || !evaluates
        });
        assert_eq!((updates, online.probes()), (1, false), "{steady} {q}: {probing}");
    }
}
