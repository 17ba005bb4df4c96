//! Tests on a stack of Rm 40 ohm and a susceptance of 20 mS, driven with 10 V. Its time constant is
//! 16 blocks.

use super::*;

pub(super) const VOLTS: f32 = 10.0;
pub(super) const LIMIT_V: f32 = 25.0;
pub(super) const SUSCEPTANCE: f32 = 0.02;
pub(super) const CONDUCTANCE: f32 = 0.025;
pub(super) const LOAD: Load = Load { periods: 20.7, susceptance: SUSCEPTANCE, noise: 1e-8 };

pub(super) fn watch() -> Continuity {
    Continuity::build(40e3, 32e-6, 32, LIMIT_V)
}

/// Returns a block with this voltage, motional current and clamped capacitance, relative to the
/// lock.
pub(super) fn block(voltage: Phasor, motional: Phasor, clamped: f32) -> Steady {
    let v = voltage * VOLTS;
    let motional = motional * CONDUCTANCE * VOLTS + Phasor::new(0.0, (clamped - 1.0) * SUSCEPTANCE * VOLTS);
    let i = motional + Phasor::new(0.0, SUSCEPTANCE) * v;
    Steady { volts: VOLTS, offset_hz: 0.0, v, i, motional, tracked: true, hard: true, unexplained: false }
}

pub(super) fn one() -> Phasor {
    Phasor::new(1.0, 0.0)
}

/// Returns the number of such blocks until a failure is detected, if within 400.
pub(super) fn known_after(change: impl Fn(usize) -> Steady) -> Option<usize> {
    let mut watch = watch();
    (0..100).for_each(|_| assert!(!watch.check_steady_block(&block(one(), one(), 1.0), || LOAD)));
    (0..400).position(|n| watch.check_steady_block(&change(n), || LOAD)).map(|n| n + 1)
}

/// A single bad block is ignored; of consecutive bad blocks, every second is ignored.
#[test]
fn a_single_bad_block_is_out_of_sequence() {
    let good = || block(one(), one(), 1.0);
    let elsewhere = || block(one() * Phasor::new(0.0, 1.0), one(), 1.0);
    let out_of_sequence = |of: fn(&mut Continuity, &Steady), what: Steady| {
        let mut watch = watch();
        (0..100).for_each(|_| assert!(!watch.check_steady_block(&good(), || LOAD) && !watch.is_out_of_sequence()));
        of(&mut watch, &what);
        let first = watch.is_out_of_sequence();
        of(&mut watch, &what);
        (first, watch.is_out_of_sequence())
    };
    let judged: fn(&mut Continuity, &Steady) = |watch, block| assert!(!watch.check_steady_block(block, || LOAD));
    assert_eq!(out_of_sequence(judged, elsewhere()), (true, false));
    assert_eq!(out_of_sequence(judged, Steady { unexplained: true, ..good() }), (true, false));
    assert_eq!(out_of_sequence(judged, block(one() * 1.2, one() * 0.5, 1.0)), (false, false));
    assert_eq!(out_of_sequence(Continuity::mark_implausible, good()), (true, false));
    // Without tracking no block has to be ignored.
    assert_eq!(out_of_sequence(judged, Steady { tracked: false, ..elsewhere() }), (false, false));
}

/// The threshold is half of the voltage, at any gain and amplitude, after `CALM_BLOCKS` steady
/// blocks.
#[test]
fn out_of_sequence_needs_half_the_voltage_and_a_steady_drive() {
    let out_of_sequence = |after: usize, part: f32| {
        let mut watch = watch();
        (0..after).for_each(|_| assert!(!watch.check_steady_block(&block(one() * 0.5, one(), 1.0), || LOAD)));
        let (volts, good) = (4.0, block(one(), one(), 1.0));
        watch.check_steady_block(&Steady { volts, v: one() * (0.5 * (1.0 - part) * volts), ..good }, || LOAD);
        watch.is_out_of_sequence()
    };
    assert_eq!((out_of_sequence(100, 0.55), out_of_sequence(100, -0.55), out_of_sequence(100, 0.45)), (true, true, false));
    assert_eq!((out_of_sequence(CALM_BLOCKS as usize, 0.55), out_of_sequence(CALM_BLOCKS as usize - 1, 0.55)), (true, false));
}

/// A measuring tone may exceed the limit or be distorted for at most seven blocks.
#[test]
fn a_measuring_tone_is_checked_for_limit_and_distortion() {
    let known = |louder: f32, distorted: fn(usize) -> bool| {
        let mut watch = watch();
        (0..400).position(|n| watch.check_measuring_block(one() * louder * LIMIT_V, distorted(n), false)).map(|n| n + 1)
    };
    assert_eq!((known(1.14, |_| false), known(1.16, |_| false)), (None, Some(8)));
    assert_eq!(watch().most_volts(), 1.15 * LIMIT_V);
    assert_eq!((known(0.5, |n| n % 8 < 7), known(0.5, |_| true)), (None, Some(8)));
}

/// Returns the same after 100 blocks like `before`, under this load.
pub(super) fn found(before: Steady, load: Load, change: impl Fn(usize) -> Steady) -> Option<usize> {
    let mut watch = watch();
    (0..100).for_each(|_| assert!(!watch.check_steady_block(&before, || load)));
    (0..400).position(|n| watch.check_steady_block(&change(n), || load)).map(|n| n + 1)
}

/// Returns a block without tracking: only its voltage is judged, its current is arbitrary.
pub(super) fn untracked(voltage: Phasor, motional: Phasor) -> Steady {
    Steady { tracked: false, ..block(voltage, motional, 1.0) }
}

#[test]
fn without_tracking_only_the_voltage_is_judged() {
    let jumps = Steady { unexplained: true, ..untracked(one(), one() * 0.3) };
    assert_eq!(found(untracked(one(), one()), LOAD, |_| jumps), None);
    assert_eq!(found(untracked(one(), one()), LOAD, |_| untracked(one() * 0.8, one())), Some(7));
}

#[test]
fn only_a_new_order_resets_the_checks() {
    for (ordered, known) in [(0.0, Some(7)), (100.0, None)] {
        let mut watch = watch();
        for _ in 0..100 {
            watch.follow_order(0.0);
            assert!(!watch.check_steady_block(&untracked(one(), one()), || LOAD));
        }
        let found = (0..400).position(|_| {
            watch.follow_order(ordered);
            watch.check_steady_block(&untracked(one() * 0.7, one()), || LOAD)
        });
        assert_eq!(found.map(|n| n + 1), known, "{ordered} Hz");
    }
}

#[test]
fn a_failure_stays_until_a_new_attempt() {
    let mut watch = watch();
    (0..100).for_each(|_| assert!(!watch.check_steady_block(&untracked(one(), one()), || LOAD)));
    assert!(!watch.has_failed());
    assert!((0..7).any(|_| watch.check_steady_block(&untracked(-one(), one()), || LOAD)));
    assert!(watch.has_failed());
    watch.rest(true);
    watch.follow_order(300.0);
    assert!(watch.check_steady_block(&untracked(one(), one()), || LOAD) && watch.has_failed());
    watch.restart();
    assert!(!watch.has_failed());
    assert!((0..400).all(|_| !watch.check_steady_block(&untracked(-one(), one()), || LOAD)));
}

/// A small drive hides a failed channel: its energy shows it, after the time in which a vibration
/// rings. Judged blocks between them count as healthy.
#[test]
fn energy_without_a_drive_is_detected_after_the_ringing() {
    let mut watch = watch();
    let mut found =
        |unexplained: bool, periods: f32, blocks: u32| (0..blocks).position(|_| watch.check_small_block(unexplained, periods));
    assert_eq!(found(true, 1.0, CALM_BLOCKS - 1), None);
    assert_eq!(found(false, 1.0, 1), None);
    assert_eq!(found(true, 1.0, 2 * CALM_BLOCKS), Some(CALM_BLOCKS as usize - 1));
    assert_eq!(found(false, 1.0, 1), None);
    // A time constant of 100 periods rings for 700 periods, 547 blocks of 1.28 periods.
    assert_eq!(found(true, 100.0, 600), Some(546));
    assert_eq!(found(false, 1.0, 1), None);
    let healthy = block(one(), one(), 1.0);
    for _ in 0..8 {
        assert!((0..20).all(|_| !watch.check_small_block(true, 1.0)));
        assert!((0..4).all(|_| !watch.check_steady_block(&healthy, || LOAD)));
    }
}
