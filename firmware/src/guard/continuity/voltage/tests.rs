//! Voltages that the drive, a source and a delay explain, and others.

use super::super::tests::*;
use super::super::*;

#[test]
fn a_changed_voltage_is_detected_within_eight_blocks() {
    let turned = Phasor::new(0.96, 0.28);
    for voltage in [one() * 1.2, one() * 0.8, -one(), turned] {
        assert_eq!(known_after(|_| block(voltage, one(), 1.0)), Some(7), "{voltage}");
        assert_eq!(known_after(|n| block(if n % 8 < 6 { voltage } else { one() }, one(), 1.0)), None, "{voltage}");
    }
    assert_eq!(known_after(|_| block(one() * 1.1, one(), 1.0)), None);
    // A slow rise to 1.2 times the command is detected too.
    assert!(known_after(|n| block(one() * (1.0 + 1e-3 * n as f32), one(), 1.0)).is_some_and(|n| (200..=210).contains(&n)));
    assert_eq!(known_after(|n| Steady { unexplained: n % 8 < 6, ..block(one(), one(), 1.0) }), None);
    assert_eq!(known_after(|_| Steady { unexplained: true, ..block(one(), one(), 1.0) }), Some(7));
}

/// If the gain was wrong from the beginning, only the voltage limit can show it.
#[test]
fn a_voltage_above_its_limit_is_detected() {
    let known = |louder: f32| {
        let mut watch = watch();
        (0..400).position(|_| watch.check_steady_block(&block(one() * louder, one(), 1.0), || LOAD)).map(|n| n + 1)
    };
    assert_eq!((known(1.15 * LIMIT_V / VOLTS - 0.01), known(1.15 * LIMIT_V / VOLTS + 0.01)), (None, Some(7)));
}

#[test]
fn a_source_and_a_delay_explain_a_voltage() {
    // Four times the current takes 30 % from the voltage at 4 ohm; no source raises it as much.
    let sags = |ohm: f32| {
        known_after(|n| {
            let rise = 3.0 * (1.0 - libm::expf(-(n as f32) / 16.0));
            block(one() * (1.0 - ohm * CONDUCTANCE * rise), one() * (1.0 + rise), 1.0)
        })
    };
    assert_eq!((sags(4.0), sags(-4.0).is_some()), (None, true));
    // If the frequency changes by 500 Hz, a delay of 100 us turns the voltage by 18 degrees.
    let turned = Phasor::new(0.951, -0.309);
    let delayed = |hz: f32| known_after(|_| Steady { offset_hz: hz, ..block(turned, one(), 1.0) });
    assert_eq!((delayed(500.0), delayed(0.0)), (None, Some(7)));
}

#[test]
fn a_voltage_may_change_by_15_percent() {
    for (level, part, known) in [(1.0, 0.149, None), (1.0, 0.151, Some(7)), (0.5, 0.148, None), (0.5, 0.152, Some(7))] {
        for part in [1.0 - part, 1.0 + part] {
            let found = found(block(one() * level, one(), 1.0), LOAD, |_| block(one() * level * part, one(), 1.0));
            assert_eq!(found, known, "{level} {part}");
        }
    }
}

#[test]
fn a_voltage_is_at_most_1_2_times_command_or_reference() {
    for (begins, blocks) in [(0.9, 300), (1.0, 200), (1.3, 260)] {
        let rises = |n: usize| block(one() * (begins + 1e-3 * n as f32), one(), 1.0);
        let found = found(block(one() * begins, one(), 1.0), LOAD, rises);
        assert!(found.is_some_and(|n| (blocks..=blocks + 10).contains(&n)), "{begins}: {found:?}");
    }
}

#[test]
fn the_reference_is_the_mean_of_sixteen_checks() {
    // Every second block is checked. The first check reads twice the voltage, or all alternate
    // between 0.9 and 1.1 of it.
    let runs = |first: fn(usize) -> f32, then: &dyn Fn(usize) -> f32| {
        let mut watch = watch();
        (0..32).for_each(|n| assert!(!watch.check_steady_block(&untracked(one() * first(n / 2), one()), || LOAD)));
        (0..400).position(|n| watch.check_steady_block(&untracked(one() * then(n), one()), || LOAD))
    };
    let known = runs(|n| if n == 0 { 2.0 } else { 1.0 }, &|n| 1.0625 + 1e-3 * n as f32);
    assert!(known.is_some_and(|n| (210..225).contains(&n)), "{known:?}");
    assert_eq!(runs(|n| 0.9 + 0.2 * (n % 2) as f32, &|_| 0.87), None);
    assert!(runs(|n| 0.9 + 0.2 * (n % 2) as f32, &|_| 0.84).is_some());
}

#[test]
fn a_source_of_up_to_five_ohm_is_accepted() {
    for level in [1.0, 0.5] {
        // The current has risen by three times. 7 ohm leave more than 15 % unexplained; so does a
        // turned voltage.
        let changes =
            |part: Phasor| found(untracked(one() * level, one()), LOAD, |_| untracked(part * level, one() * (1.0 + 3.0 * level)));
        let sags = |ohm: f32| changes(one() - one() * (ohm * 3.0 * CONDUCTANCE));
        assert_eq!([sags(2.4), sags(4.0), sags(6.8), sags(7.0)], [None, None, None, Some(7)], "{level}");
        assert_eq!([0.14, 0.2].map(|turned| changes(Phasor::new(0.7, turned))), [None, Some(7)], "{level}");
        // A voltage below a tenth has collapsed at any current.
        let collapses = |part: f32| {
            found(untracked(one() * level, one()), LOAD, |_| untracked(one() * part * level, one() * (1.0 + 8.0 * level)))
        };
        assert_eq!([collapses(0.11), collapses(0.09)], [None, Some(7)], "{level}");
    }
}

#[test]
fn a_delay_of_up_to_100_us_is_accepted() {
    // Relative to the mean frequency, 500 Hz explain a turn of 0.31, in addition to 0.15.
    let at = |offset_hz: f32, off: f32| Steady { offset_hz, ..untracked(Phasor::new(1.0, off), one()) };
    let turns = |offset_hz: f32, off: f32| {
        let mut watch = watch();
        // The frequency alternates between 400 and 600 Hz.
        (0..200).for_each(|n| assert!(!watch.check_steady_block(&at(400.0 + 200.0 * (n / 2 % 2) as f32, 0.0), || LOAD)));
        (0..400).position(|_| watch.check_steady_block(&at(offset_hz, off), || LOAD)).map(|n| n + 1)
    };
    assert_eq!([turns(1000.0, 0.45), turns(0.0, 0.45)], [None; 2]);
    assert_eq!([turns(1000.0, 0.48), turns(0.0, 0.48), turns(500.0, 0.2)], [Some(7); 3]);
}

/// A drive that is lowered while the stack rings, with a source of 2 ohm that takes `taken` of the
/// drive at the resonance. The voltage passes zero, where its tone leaves energy unexplained; the
/// error of the clamped branch moves the motional current with it. A short is detected, also while
/// the stack rings.
#[test]
fn a_lower_drive_on_a_ringing_stack_is_accepted() {
    for (taken, part) in [0.05, 0.5, 0.9].into_iter().flat_map(|taken| [0.3, 0.49, 0.8].map(|part| (taken, part))) {
        for short_at in [usize::MAX, 0, 1, 20, 80, 300] {
            let mut watch = watch();
            // Relative to the drive before, and to the current before.
            let at = |volts: f32, current: f32| {
                let v = volts - taken * current;
                let (i, error) = (current * 0.5 * taken * VOLTS, 0.3 * SUSCEPTANCE * v * VOLTS);
                let unexplained = (v * VOLTS).abs() < 0.03;
                let (v, i) = (Phasor::new(v * VOLTS, 0.0), Phasor::new(i, 0.0));
                Steady { volts: volts * VOLTS, motional: Phasor::new(i.re, error), v, i, unexplained, ..block(one(), one(), 1.0) }
            };
            (0..200).for_each(|_| assert!(!watch.check_steady_block(&at(1.0, 1.0), || LOAD)));
            let found = (0..600).position(|n| {
                let ringing = part + (1.0 - part) * (-(n as f32) / 40.0).exp();
                // A short leaves a thousandth of the drive.
                let current = if n >= short_at { 0.999 * part / taken } else { ringing };
                watch.check_steady_block(&at(part, current), || LOAD)
            });
            let most = short_at.saturating_add(250);
            assert_eq!(
                found.map(|n| (short_at..most).contains(&n)),
                (short_at < 600).then_some(true),
                "{taken} {part} {short_at} {found:?}"
            );
        }
    }
}
