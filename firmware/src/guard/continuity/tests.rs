//! A stack of Rm 40 ohm and a susceptance of 20 mS, driven with 10 V, whose time constant is 16 blocks; and what happens to it.

use super::*;

const VOLTS: f32 = 10.0;
const LIMIT_V: f32 = 25.0;
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

/// A single block that is none of the drive says nothing, whatever is wrong with it; of those that follow one another every second.
#[test]
fn a_block_of_another_one_is_torn() {
    let good = || block(one(), one(), 1.0);
    let elsewhere = || block(one() * Phasor::new(0.0, 1.0), one(), 1.0);
    let torn = |of: fn(&mut Continuity, &Steady), what: Steady| {
        let mut watch = watch();
        (0..100).for_each(|_| assert!(!watch.is_broken(&good(), || LOAD) && !watch.is_torn()));
        of(&mut watch, &what);
        let first = watch.is_torn();
        of(&mut watch, &what);
        (first, watch.is_torn())
    };
    let judged: fn(&mut Continuity, &Steady) = |watch, block| assert!(!watch.is_broken(block, || LOAD));
    assert_eq!(torn(judged, elsewhere()), (true, false));
    assert_eq!(torn(judged, Steady { unexplained: true, ..good() }), (true, false));
    assert_eq!(torn(judged, block(one() * 1.2, one() * 0.5, 1.0)), (false, false));
    assert_eq!(torn(Continuity::doubt, good()), (true, false));
    // Where nothing is tracked, nothing is led astray.
    assert_eq!(torn(judged, Steady { tracked: false, ..elsewhere() }), (false, false));
}

/// By half of what it was, at any gain and amplitude; and not while it may still ring at another frequency.
#[test]
fn a_torn_block_is_far_from_a_drive_that_has_long_been_steady() {
    let torn = |after: usize, part: f32| {
        let mut watch = watch();
        (0..after).for_each(|_| assert!(!watch.is_broken(&block(one() * 0.5, one(), 1.0), || LOAD)));
        let (volts, good) = (4.0, block(one(), one(), 1.0));
        watch.is_broken(&Steady { volts, v: one() * (0.5 * (1.0 - part) * volts), ..good }, || LOAD);
        watch.is_torn()
    };
    assert_eq!((torn(100, 0.55), torn(100, -0.55), torn(100, 0.45)), (true, true, false));
    assert_eq!((torn(CALM_BLOCKS as usize, 0.55), torn(CALM_BLOCKS as usize - 1, 0.55)), (true, false));
}

/// Of an amplifier that was so from the beginning nothing is known but its limit.
#[test]
fn no_voltage_is_much_above_its_limit() {
    let known = |louder: f32| {
        let mut watch = watch();
        (0..400).position(|_| watch.is_broken(&block(one() * louder, one(), 1.0), || LOAD)).map(|n| n + 1)
    };
    assert_eq!((known(1.15 * LIMIT_V / VOLTS - 0.01), known(1.15 * LIMIT_V / VOLTS + 0.01)), (None, Some(7)));
}

/// Nor is that of a tone that measures, or it is no tone, for longer than eight blocks.
#[test]
fn a_tone_that_measures_is_a_tone_within_its_limit() {
    let known = |louder: f32, distorted: fn(usize) -> bool| {
        let mut watch = watch();
        (0..400).position(|n| watch.is_misplayed(one() * louder * LIMIT_V, distorted(n), false)).map(|n| n + 1)
    };
    assert_eq!((known(1.14, |_| false), known(1.16, |_| false)), (None, Some(8)));
    assert_eq!(watch().most_volts(), 1.15 * LIMIT_V);
    assert_eq!((known(0.5, |n| n % 8 < 7), known(0.5, |_| true)), (None, Some(8)));
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

/// Wherever in the window it is driven: what turns the current of a resonance is how far the frequency is from where it was.
#[test]
fn a_current_that_jumps_beside_the_nominal_frequency_is_no_load() {
    let mut watch = watch();
    let at = |gain: f32| Steady { offset_hz: 900.0, ..block(one(), one() * gain, 1.0) };
    (0..100).for_each(|_| assert!(!watch.is_broken(&at(1.0), || LOAD)));
    assert!((0..400).any(|_| watch.is_broken(&at(0.7), || LOAD)));
}

/// A channel that is reversed within a block leaves a part of its current, and no sine.
#[test]
fn a_jump_within_a_block_is_known_as_soon() {
    for part in [0.9, 0.5, 0.0, -0.5, -0.9] {
        for first in [0, 1] {
            let torn = |n: usize| n == first && part * part < 0.9;
            let left = |n: usize| match n {
                n if n < first => 1.0,
                n if n == first => part,
                _ => -1.0,
            };
            let known = known_after(|n| {
                let i = one() * left(n);
                Steady {
                    unexplained: torn(n),
                    ..block(one(), i + (i - one()) * Phasor::new(0.0, SUSCEPTANCE / CONDUCTANCE), 1.0)
                }
            });
            assert!(known.is_some_and(|known| known <= 6), "{part} of block {first}: {known:?}");
        }
    }
}

/// Of 1 kHz in 3 blocks, at each moment of a block: 0.6 rad. A current that is reversed jumps by more, wherever the tracker goes with it.
#[test]
fn a_resonance_that_jumps_and_is_followed_is_no_failure() {
    for moment in [0.0, 0.25, 0.5, 0.75] {
        for parity in 0..2 {
            let turned = |n: usize| {
                let blocks = (n as f32 - parity as f32 - moment + 0.5).clamp(0.0, 3.0);
                let (sin, cos) = libm::sincosf(core::f32::consts::TAU * 1e3 * 32e-6 * blocks);
                Phasor::new(cos, sin)
            };
            let offset_hz = |n: usize| if n < 3 + parity { 0.0 } else { -1e3 };
            let after = |sign: f32| known_after(|n| Steady { offset_hz: offset_hz(n), ..block(one(), turned(n) * sign, 1.0) });
            assert_eq!((after(1.0), after(-1.0).is_some()), (None, true), "{moment} {parity}");
        }
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

/// The same of a watch that has begun with 100 blocks like `before`, under this load.
fn found(before: Steady, load: Load, change: impl Fn(usize) -> Steady) -> Option<usize> {
    let mut watch = watch();
    (0..100).for_each(|_| assert!(!watch.is_broken(&before, || load)));
    (0..400).position(|n| watch.is_broken(&change(n), || load)).map(|n| n + 1)
}

#[test]
fn a_current_that_has_swung_is_known_by_its_mean() {
    let swings = |n: usize| untracked(one(), one() * (0.8 + 0.2 * (n / 2 % 3) as f32));
    let mut watch = watch();
    (0..600).for_each(|n| assert!(!watch.is_broken(&swings(n), || LOAD)));
    assert!(
        (watch.current - Phasor::new(CONDUCTANCE, SUSCEPTANCE)).norm_sqr() < 1e-2 * CONDUCTANCE * CONDUCTANCE,
        "{}",
        watch.current
    );
    // Three times that current takes 30 % from the voltage, at 4 ohm.
    assert!((0..100).all(|_| !watch.is_broken(&untracked(one() * 0.7, one() * 4.0), || LOAD)));
}

/// A block whose current may do what it wants: only the voltage of what is not tracked is judged.
fn untracked(voltage: Phasor, motional: Phasor) -> Steady {
    Steady { tracked: false, ..block(voltage, motional, 1.0) }
}

#[test]
fn a_voltage_may_move_by_fifteen_per_cent_of_what_it_was() {
    for (level, part, known) in [(1.0, 0.149, None), (1.0, 0.151, Some(7)), (0.5, 0.148, None), (0.5, 0.152, Some(7))] {
        for part in [1.0 - part, 1.0 + part] {
            let found = found(block(one() * level, one(), 1.0), LOAD, |_| block(one() * level * part, one(), 1.0));
            assert_eq!(found, known, "{level} {part}");
        }
    }
}

#[test]
fn a_voltage_is_at_most_a_fifth_louder_than_ordered_or_than_in_the_beginning() {
    for (begins, blocks) in [(0.9, 300), (1.0, 200), (1.3, 260)] {
        let rises = |n: usize| block(one() * (begins + 1e-3 * n as f32), one(), 1.0);
        let found = found(block(one() * begins, one(), 1.0), LOAD, rises);
        assert!(found.is_some_and(|n| (blocks..=blocks + 10).contains(&n)), "{begins}: {found:?}");
    }
}

#[test]
fn the_beginning_is_the_mean_of_sixteen_blocks() {
    // Every second block is looked at. The first is twice as loud, or the last one is off by a tenth.
    let runs = |first: fn(usize) -> f32, then: &dyn Fn(usize) -> f32| {
        let mut watch = watch();
        (0..32).for_each(|n| assert!(!watch.is_broken(&untracked(one() * first(n / 2), one()), || LOAD)));
        (0..400).position(|n| watch.is_broken(&untracked(one() * then(n), one()), || LOAD))
    };
    let known = runs(|n| if n == 0 { 2.0 } else { 1.0 }, &|n| 1.0625 + 1e-3 * n as f32);
    assert!(known.is_some_and(|n| (210..225).contains(&n)), "{known:?}");
    assert_eq!(runs(|n| 0.9 + 0.2 * (n % 2) as f32, &|_| 0.87), None);
    assert!(runs(|n| 0.9 + 0.2 * (n % 2) as f32, &|_| 0.84).is_some());
}

#[test]
fn a_source_of_five_ohm_is_believed_and_no_more() {
    for level in [1.0, 0.5] {
        // The current has risen threefold; 7 ohm leave more than 15 % unexplained, and so does a voltage that turns.
        let changes =
            |part: Phasor| found(untracked(one() * level, one()), LOAD, |_| untracked(part * level, one() * (1.0 + 3.0 * level)));
        let sags = |ohm: f32| changes(one() - one() * (ohm * 3.0 * CONDUCTANCE));
        assert_eq!([sags(2.4), sags(4.0), sags(6.8), sags(7.0)], [None, None, None, Some(7)], "{level}");
        assert_eq!([0.14, 0.2].map(|turned| changes(Phasor::new(0.7, turned))), [None, Some(7)], "{level}");
        // Less than a tenth is a voltage that has collapsed, whatever the current.
        let collapses = |part: f32| {
            found(untracked(one() * level, one()), LOAD, |_| untracked(one() * part * level, one() * (1.0 + 8.0 * level)))
        };
        assert_eq!([collapses(0.11), collapses(0.09)], [None, Some(7)], "{level}");
    }
}

#[test]
fn a_delay_of_a_tenth_of_a_millisecond_is_believed_and_no_more() {
    // From where the frequency has been: 0.31 for 500 Hz, beside 0.15.
    let at = |offset_hz: f32, off: f32| Steady { offset_hz, ..untracked(Phasor::new(1.0, off), one()) };
    let turns = |offset_hz: f32, off: f32| {
        let mut watch = watch();
        // It has been 400 and 600 Hz by turns.
        (0..200).for_each(|n| assert!(!watch.is_broken(&at(400.0 + 200.0 * (n / 2 % 2) as f32, 0.0), || LOAD)));
        (0..400).position(|_| watch.is_broken(&at(offset_hz, off), || LOAD)).map(|n| n + 1)
    };
    assert_eq!([turns(1000.0, 0.45), turns(0.0, 0.45)], [None; 2]);
    assert_eq!([turns(1000.0, 0.48), turns(0.0, 0.48), turns(500.0, 0.2)], [Some(7); 3]);
}

#[test]
fn where_nothing_is_tracked_only_the_voltage_is_judged() {
    let jumps = Steady { unexplained: true, ..untracked(one(), one() * 0.3) };
    assert_eq!(found(untracked(one(), one()), LOAD, |_| jumps), None);
    assert_eq!(found(untracked(one(), one()), LOAD, |_| untracked(one() * 0.8, one())), Some(7));
}

#[test]
fn another_order_begins_anew_and_the_same_one_does_not() {
    for (ordered, known) in [(0.0, Some(7)), (100.0, None)] {
        let mut watch = watch();
        for _ in 0..100 {
            watch.follow_order(0.0);
            assert!(!watch.is_broken(&untracked(one(), one()), || LOAD));
        }
        let found = (0..400).position(|_| {
            watch.follow_order(ordered);
            watch.is_broken(&untracked(one() * 0.7, one()), || LOAD)
        });
        assert_eq!(found.map(|n| n + 1), known, "{ordered} Hz");
    }
}

#[test]
fn what_has_failed_stays_so_until_a_new_attempt() {
    let mut watch = watch();
    (0..100).for_each(|_| assert!(!watch.is_broken(&untracked(one(), one()), || LOAD)));
    assert!(!watch.has_failed());
    assert!((0..7).any(|_| watch.is_broken(&untracked(-one(), one()), || LOAD)));
    assert!(watch.has_failed());
    watch.rest(true);
    watch.follow_order(300.0);
    assert!(watch.is_broken(&untracked(one(), one()), || LOAD) && watch.has_failed());
    watch.restart();
    assert!(!watch.has_failed());
    assert!((0..400).all(|_| !watch.is_broken(&untracked(-one(), one()), || LOAD)));
}

#[test]
fn a_jump_is_judged_by_load_and_noise() {
    let jumps = |load: Load| {
        let gain = Phasor::new(0.7, 0.0);
        let clamped = (gain - one()) * Phasor::new(0.0, SUSCEPTANCE / CONDUCTANCE);
        found(block(one(), one(), 1.0), load, |_| block(one(), one() * gain + clamped, 1.0)).is_some()
    };
    // A jump of 96 mA is eight deviations of a noise of 8.5 mA in both components.
    assert_eq!([7.0e-5, 7.4e-5].map(|noise| jumps(Load { noise, ..LOAD })), [true, false]);
    // A time constant of four blocks.
    assert_eq!([5.1, 5.2].map(|periods| jumps(Load { periods, ..LOAD })), [false, true]);
}

#[test]
fn a_clamped_capacitance_that_changes_is_upright_and_leaves_a_fifth() {
    let jumps = |siemens: f32, clamped: f32| {
        found(block(one(), one(), 1.0), LOAD, |_| block(one(), one() * (1.0 + siemens / CONDUCTANCE), clamped)).is_some()
    };
    // 12 mS more, with less or more than a fifth of it beside.
    assert_eq!([2.2e-3, 2.6e-3, -2.2e-3, -2.6e-3].map(|beside| jumps(beside, 1.6)), [false, true, false, true]);
    assert_eq!([0.21, 0.19].map(|left| jumps(0.0, left)), [false, true]);
}

/// A burst in which the stack rings up, of 64 blocks, after a pause, and its current is turned; after how many blocks it is known.
fn burst(watch: &mut Continuity, silent: bool, pause: usize, gain: Phasor, clamped: f32) -> Option<usize> {
    (0..pause).for_each(|_| watch.rest(silent));
    (0..64).position(|n| {
        let rung = one() * (1.0 - libm::expf(-(n as f32 + 1.0) / 16.0));
        let extra = (gain * clamped - one()) * Phasor::new(0.0, SUSCEPTANCE / CONDUCTANCE);
        watch.is_broken(&block(one(), rung * gain + extra, 1.0), || LOAD)
    })
}

#[test]
fn a_pause_counts_from_seven_time_constants_of_silence_on() {
    // 145 periods of 1.28 a block.
    let first = |silent: bool, pause: usize| burst(&mut watch(), silent, pause, -one(), 1.0);
    assert_eq!([first(true, 113), first(true, 114), first(false, 1000)], [None, Some(1), None]);
    // The pause before an earlier burst is over: after a short one the stack may still ring.
    let mut rings = watch();
    assert_eq!([0; 2].map(|_| burst(&mut rings, true, 200, one(), 1.0)), [None; 2]);
    (0..60).for_each(|_| rings.rest(true));
    assert!((0..64).all(|_| !rings.is_broken(&block(one(), one(), 1.0), || LOAD)));
}

/// A drive that fades in after a pause is too faint to be judged at first, and the stack has rung up by the time that it is.
#[test]
fn a_drive_that_fades_in_is_no_failure() {
    for faint in [0, 1, 20] {
        let mut watch = watch();
        (0..200).for_each(|_| watch.rest(true));
        (0..faint).for_each(|_| watch.rings());
        let found = (0..64).position(|_| watch.is_broken(&block(one(), one(), 1.0), || LOAD));
        assert_eq!(found, (faint == 0).then_some(1), "{faint}");
    }
}

#[test]
fn a_burst_begins_as_the_one_before() {
    let second = |turn: f32, gain: f32, clamped: f32| {
        let mut watch = watch();
        assert_eq!(burst(&mut watch, true, 200, one(), 1.0), None);
        burst(&mut watch, true, 200, Phasor::new(turn.cos(), turn.sin()) * gain, clamped)
    };
    // By 15 % of the current and the ring-up of a block, both together.
    assert_eq!([second(0.22, 1.0, 1.0), second(-0.22, 1.0, 1.0), second(0.0, 1.1, 1.0)], [None; 3]);
    assert_eq!([second(0.25, 1.0, 1.0), second(-0.25, 1.0, 1.0)], [Some(1); 2]);
    // A clamped capacitance that has changed in the pause is no failure.
    assert_eq!([second(0.0, 1.0, 2.0), second(0.0, 1.0, 0.5)], [None; 2]);
}
