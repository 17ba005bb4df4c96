//! A stack of Rm 40 ohm and a susceptance of 20 mS, driven with 10 V, whose time constant is 16 blocks; and what happens to it.

use super::*;

const VOLTS: f32 = 10.0;
const LIMIT_V: f32 = 15.0;
const SUSCEPTANCE: f32 = 0.02;
const CONDUCTANCE: f32 = 0.025;
const LOAD: Load = Load { periods: 20.7, susceptance: SUSCEPTANCE, noise: 1e-8 };

fn watch() -> Continuity {
    Continuity::build(40e3, 32e-6, LIMIT_V)
}

/// A block: its voltage and its admittance, relative to what they are at the lock.
fn block(voltage: Phasor, motional: Phasor, clamped: f32) -> Steady {
    let v = voltage * VOLTS;
    let motional = motional * CONDUCTANCE * VOLTS + Phasor::new(0.0, (clamped - 1.0) * SUSCEPTANCE * VOLTS);
    let i = motional + Phasor::new(0.0, SUSCEPTANCE) * v;
    Steady { volts: VOLTS, offset_hz: 0.0, v, i, motional, tracked: true, hard: true, unexplained: false }
}

fn one() -> Phasor {
    Phasor::new(1.0, 0.0)
}

/// After how many blocks of these, of 400, it is known that they cannot be.
fn known_after(change: impl Fn(usize) -> Steady) -> Option<usize> {
    let mut watch = watch();
    (0..100).for_each(|_| assert!(!watch.is_broken(&block(one(), one(), 1.0), || LOAD)));
    (0..400).position(|n| watch.is_broken(&change(n), || LOAD)).map(|n| n + 1)
}

#[test]
fn a_voltage_that_is_elsewhere_is_known_within_eight_blocks() {
    let turned = Phasor::new(0.96, 0.28);
    for voltage in [one() * 1.2, one() * 0.8, -one(), turned] {
        assert_eq!(known_after(|_| block(voltage, one(), 1.0)), Some(7), "{voltage}");
        assert_eq!(known_after(|n| block(if n % 8 < 6 { voltage } else { one() }, one(), 1.0)), None, "{voltage}");
    }
    assert_eq!(known_after(|_| block(one() * 1.1, one(), 1.0)), None);
    // Little by little to 1.3 of the order: louder than it may be, however slowly.
    assert!(known_after(|n| block(one() * (1.0 + 1e-3 * n as f32), one(), 1.0)).is_some_and(|n| (200..=210).contains(&n)));
    assert_eq!(known_after(|n| Steady { unexplained: n % 8 < 6, ..block(one(), one(), 1.0) }), None);
    assert_eq!(known_after(|_| Steady { unexplained: true, ..block(one(), one(), 1.0) }), Some(7));
}

/// Of an amplifier that was so from the beginning nothing is known but its limit.
#[test]
fn no_voltage_is_more_than_a_fifth_above_its_limit() {
    let known = |louder: f32| {
        let mut watch = watch();
        (0..400).position(|_| watch.is_broken(&block(one() * louder, one(), 1.0), || LOAD)).map(|n| n + 1)
    };
    assert_eq!((known(1.2 * LIMIT_V / VOLTS - 0.01), known(1.2 * LIMIT_V / VOLTS + 0.01)), (None, Some(7)));
}

#[test]
fn a_source_and_a_delay_explain_a_voltage() {
    // Four times the current takes 30 % from the voltage, at 4 ohm; no source adds as much.
    let sags = |ohm: f32| {
        known_after(|n| {
            let rise = 3.0 * (1.0 - libm::expf(-(n as f32) / 16.0));
            block(one() * (1.0 - ohm * CONDUCTANCE * rise), one() * (1.0 + rise), 1.0)
        })
    };
    assert_eq!((sags(4.0), sags(-4.0).is_some()), (None, true));
    // 100 us turn the voltage of another 500 Hz by 18 degrees.
    let turned = Phasor::new(0.951, -0.309);
    let delayed = |hz: f32| known_after(|_| Steady { offset_hz: hz, ..block(turned, one(), 1.0) });
    assert_eq!((delayed(500.0), delayed(0.0)), (None, Some(7)));
}

#[test]
fn a_current_that_jumps_is_no_load() {
    let jump = |motional: Phasor, clamped: f32| known_after(|_| block(one(), motional, clamped));
    // What is read of it is 0.7 or 1.3 of it, or the opposite, or three samples late at 40 kHz: also of the part that the clamped capacitance takes.
    let late = Phasor::new(0.73, -0.68);
    for gain in [one() * 0.7, one() * 1.3, -one(), late] {
        let clamped = (gain - one()) * Phasor::new(0.0, SUSCEPTANCE / CONDUCTANCE);
        let known = jump(one() * gain + clamped, 1.0);
        assert!(known.is_some_and(|n| n <= 4), "{gain}: {known:?}");
    }
    // Clamped capacitances that change, but not one that is gone.
    assert_eq!([0.5, 0.8, 1.5, 2.0].map(|clamped| jump(one(), clamped)), [None; 4]);
    assert!(jump(one(), 0.0).is_some());
    // A glitch of one block or two.
    assert_eq!([1, 2].map(|blocks| known_after(|n| block(one(), one() * if n < blocks { 0.3 } else { 1.0 }, 1.0))), [None; 2]);
    // A load: of twice to ten times the damping, or a third of it, the current goes where it belongs within the new time constant.
    for damping in [0.33, 2.0, 5.0, 10.0] {
        let bent = |n: usize| 1.0 / damping + (1.0 - 1.0 / damping) * libm::expf(-(n as f32) * damping / 16.0);
        assert_eq!(known_after(|n| block(one(), one() * bent(n), 1.0)), None, "{damping}");
    }
}

#[test]
fn what_fails_in_a_pause_is_known_when_it_is_over() {
    let ring_up = |n: usize, gain: f32| {
        let rung = one() * (1.0 - libm::expf(-(n as f32 + 1.0) / 16.0));
        block(one(), rung * gain + Phasor::new(0.0, (gain - 1.0) * SUSCEPTANCE / CONDUCTANCE), 1.0)
    };
    let burst = |watch: &mut Continuity, gain: f32, pause: usize| {
        (0..pause).for_each(|_| watch.rest(true));
        (0..64).position(|n| watch.is_broken(&ring_up(n, gain), || LOAD))
    };
    // The first burst is compared with the clamped branch; after a short pause the stack may still ring.
    let mut first = watch();
    assert_eq!(burst(&mut first, -1.0, 200), Some(1));
    let mut later = watch();
    assert_eq!([200, 200, 30, 200].map(|pause| burst(&mut later, 1.0, pause)), [None; 4]);
    assert_eq!(burst(&mut later, -1.0, 200), Some(1));
}
