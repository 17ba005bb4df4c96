//! Jumps of the current that a load cannot make, and those that it can.

use super::super::tests::*;
use super::super::*;

#[test]
fn a_current_jump_is_not_a_load() {
    let jump = |motional: Phasor, clamped: f32| known_after(|_| block(one(), motional, clamped));
    // The channel reads 0.7 or 1.3 of the current, its opposite, or three samples late at 40 kHz:
    // also for the part of the clamped capacitance.
    let late = Phasor::new(0.73, -0.68);
    for gain in [one() * 0.7, one() * 1.3, -one(), late] {
        let clamped = (gain - one()) * Phasor::new(0.0, SUSCEPTANCE / CONDUCTANCE);
        let known = jump(one() * gain + clamped, 1.0);
        assert!(known.is_some_and(|n| n <= 4), "{gain}: {known:?}");
    }
    // Changes of the clamped capacitance are accepted, its loss is not.
    assert_eq!([0.5, 0.8, 1.5, 2.0].map(|clamped| jump(one(), clamped)), [None; 4]);
    assert!(jump(one(), 0.0).is_some());
    // A glitch of one or two blocks is accepted.
    assert_eq!([1, 2].map(|blocks| known_after(|n| block(one(), one() * if n < blocks { 0.3 } else { 1.0 }, 1.0))), [None; 2]);
    // Loads of 0.33 to 10 times the damping: the current settles within the new time constant.
    for damping in [0.33, 2.0, 5.0, 10.0] {
        let bent = |n: usize| 1.0 / damping + (1.0 - 1.0 / damping) * libm::expf(-(n as f32) * damping / 16.0);
        assert_eq!(known_after(|n| block(one(), one() * bent(n), 1.0)), None, "{damping}");
    }
}

/// A sample is 3.6 to 10 degrees here, less than the jump that is judged otherwise. A smaller turn,
/// or one the other way, is accepted, and so is a loss of three quarters of the clamped
/// capacitance.
#[test]
fn a_current_one_sample_late_is_not_a_load() {
    for (hz, ratio) in
        [10e3, 20e3, 28e3].into_iter().flat_map(|hz| [0.03, 0.06, 0.12, 0.15, 0.18, 0.3, 0.8].map(|ratio| (hz, ratio)))
    {
        let known = |samples: f32, left: f32| {
            let mut watch = Continuity::build(hz, 32e-6, 32, LIMIT_V);
            let of = |samples: f32, left: f32| {
                let rad = core::f32::consts::TAU * hz * 1e-6 * samples;
                let clamped = Phasor::new(0.0, SUSCEPTANCE * VOLTS);
                let i = (one() * (SUSCEPTANCE / ratio * VOLTS) + clamped * left) * Phasor::new(libm::cosf(rad), -libm::sinf(rad));
                Steady { motional: i - clamped, i, ..block(one(), one(), 1.0) }
            };
            (0..100).for_each(|_| assert!(!watch.check_steady_block(&of(0.0, 1.0), || LOAD)));
            (0..400).any(|_| watch.check_steady_block(&of(samples, left), || LOAD))
        };
        let turns = [1.0, 0.9, 1.1, 0.6, -0.6].map(|samples| known(samples, 1.0));
        assert_eq!(turns, [true, true, true, false, false], "{hz} {ratio}");
        assert_eq!([0.9, 0.5, 0.25].map(|left| known(0.0, left)), [false; 3], "{hz} {ratio}");
    }
}

/// Off the nominal frequency too: only a change of the frequency turns the current of a resonance.
#[test]
fn a_current_jump_is_detected_off_the_nominal_frequency() {
    let mut watch = watch();
    let at = |gain: f32| Steady { offset_hz: 900.0, ..block(one(), one() * gain, 1.0) };
    (0..100).for_each(|_| assert!(!watch.check_steady_block(&at(1.0), || LOAD)));
    assert!((0..400).any(|_| watch.check_steady_block(&at(0.7), || LOAD)));
}

/// A block in which the channel is reversed contains part of the current, and not a sine.
#[test]
fn a_jump_within_a_block_is_detected_as_soon() {
    for part in [0.9, 0.5, 0.0, -0.5, -0.9] {
        for first in [0, 1] {
            let spans = |n: usize| n == first && part * part < 0.9;
            let left = |n: usize| match n {
                n if n < first => 1.0,
                n if n == first => part,
                _ => -1.0,
            };
            let known = known_after(|n| {
                let i = one() * left(n);
                Steady {
                    unexplained: spans(n),
                    ..block(one(), i + (i - one()) * Phasor::new(0.0, SUSCEPTANCE / CONDUCTANCE), 1.0)
                }
            });
            assert!(known.is_some_and(|known| known <= 6), "{part} of block {first}: {known:?}");
        }
    }
}

/// A jump of 1 kHz that is followed in three blocks turns the current by 0.6 rad. A reversal is
/// more, even if the tracker follows it.
#[test]
fn a_followed_jump_of_the_resonance_is_accepted() {
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
fn a_failure_in_a_pause_is_detected_after_it() {
    let ring_up = |n: usize, gain: f32| {
        let rung = one() * (1.0 - libm::expf(-(n as f32 + 1.0) / 16.0));
        block(one(), rung * gain + Phasor::new(0.0, (gain - 1.0) * SUSCEPTANCE / CONDUCTANCE), 1.0)
    };
    let burst = |watch: &mut Continuity, gain: f32, pause: usize| {
        (0..pause).for_each(|_| watch.rest(true));
        (0..64).position(|n| watch.check_steady_block(&ring_up(n, gain), || LOAD))
    };
    // The first burst is compared with the clamped branch. After a short pause the stack may still
    // ring.
    let mut first = watch();
    assert_eq!(burst(&mut first, -1.0, 200), Some(1));
    let mut later = watch();
    assert_eq!([200, 200, 30, 200].map(|pause| burst(&mut later, 1.0, pause)), [None; 4]);
    assert_eq!(burst(&mut later, -1.0, 200), Some(1));
}

#[test]
fn a_varying_current_is_compared_by_its_mean() {
    let swings = |n: usize| untracked(one(), one() * (0.8 + 0.2 * (n / 2 % 3) as f32));
    let mut watch = watch();
    (0..600).for_each(|n| assert!(!watch.check_steady_block(&swings(n), || LOAD)));
    assert!(
        (watch.current - Phasor::new(CONDUCTANCE, SUSCEPTANCE)).norm_sqr() < 1e-2 * CONDUCTANCE * CONDUCTANCE,
        "{}",
        watch.current
    );
    // Four times the mean current takes 30 % from the voltage at 4 ohm.
    assert!((0..100).all(|_| !watch.check_steady_block(&untracked(one() * 0.7, one() * 4.0), || LOAD)));
}

#[test]
fn a_jump_is_compared_with_time_constant_and_noise() {
    let jumps = |load: Load| {
        let gain = Phasor::new(0.7, 0.0);
        let clamped = (gain - one()) * Phasor::new(0.0, SUSCEPTANCE / CONDUCTANCE);
        found(block(one(), one(), 1.0), load, |_| block(one(), one() * gain + clamped, 1.0)).is_some()
    };
    // A jump of 96 mA is eight standard deviations of a noise of 8.5 mA in each component.
    assert_eq!([7.0e-5, 7.4e-5].map(|noise| jumps(Load { noise, ..LOAD })), [true, false]);
    // The shortest time constant is four blocks.
    assert_eq!([5.1, 5.2].map(|periods| jumps(Load { periods, ..LOAD })), [false, true]);
    // A source that takes three quarters of the voltage shortens it to a quarter.
    let loaded = |periods: f32| {
        let quarter = |motional: Phasor| block(one() * 0.25, motional, 1.0);
        found(quarter(one()), Load { periods, ..LOAD }, |_| quarter(one() * 0.7)).is_some()
    };
    assert_eq!([20.4, 20.6].map(loaded), [false, true]);
}

#[test]
fn a_capacitance_change_is_a_susceptance_and_leaves_a_fifth() {
    let jumps = |siemens: f32, clamped: f32| {
        found(block(one(), one(), 1.0), LOAD, |_| block(one(), one() * (1.0 + siemens / CONDUCTANCE), clamped)).is_some()
    };
    // The susceptance rises by 12 mS; the conductance changes by less or more than a fifth of that.
    assert_eq!([2.2e-3, 2.6e-3, -2.2e-3, -2.6e-3].map(|offset| jumps(offset, 1.6)), [false, true, false, true]);
    assert_eq!([0.21, 0.19].map(|left| jumps(0.0, left)), [false, true]);
}

/// Runs a burst of 64 blocks after a pause, with its ring-up and a current turned by `gain`.
/// Returns the number of blocks until a failure is detected.
fn burst(watch: &mut Continuity, silent: bool, pause: usize, gain: Phasor, clamped: f32) -> Option<usize> {
    (0..pause).for_each(|_| watch.rest(silent));
    (0..64).position(|n| {
        let rung = one() * (1.0 - libm::expf(-(n as f32 + 1.0) / 16.0));
        let extra = (gain * clamped - one()) * Phasor::new(0.0, SUSCEPTANCE / CONDUCTANCE);
        watch.check_steady_block(&block(one(), rung * gain + extra, 1.0), || LOAD)
    })
}

#[test]
fn a_pause_needs_seven_time_constants_of_silence() {
    // Seven time constants are 145 periods, at 1.28 periods a block.
    let first = |silent: bool, pause: usize| burst(&mut watch(), silent, pause, -one(), 1.0);
    assert_eq!([first(true, 113), first(true, 114), first(false, 1000)], [None, Some(1), None]);
    // An earlier, longer pause does not count: after a short one the stack may still ring.
    let mut mark_ringing = watch();
    assert_eq!([0; 2].map(|_| burst(&mut mark_ringing, true, 200, one(), 1.0)), [None; 2]);
    (0..60).for_each(|_| mark_ringing.rest(true));
    assert!((0..64).all(|_| !mark_ringing.check_steady_block(&block(one(), one(), 1.0), || LOAD)));
}

/// A drive that fades in after a pause is at first too small to be judged; later the ring-up is
/// over.
#[test]
fn a_drive_that_fades_in_is_accepted() {
    for faint in [0, 1, 20] {
        let mut watch = watch();
        (0..200).for_each(|_| watch.rest(true));
        (0..faint).for_each(|_| watch.mark_ringing());
        let found = (0..64).position(|_| watch.check_steady_block(&block(one(), one(), 1.0), || LOAD));
        assert_eq!(found, (faint == 0).then_some(1), "{faint}");
    }
}

#[test]
fn a_burst_must_start_like_the_one_before() {
    let second = |turn: f32, gain: f32, clamped: f32| {
        let mut watch = watch();
        assert_eq!(burst(&mut watch, true, 200, one(), 1.0), None);
        burst(&mut watch, true, 200, Phasor::new(turn.cos(), turn.sin()) * gain, clamped)
    };
    // The tolerance is 15 % of the current and the ring-up of a block, together.
    assert_eq!([second(0.22, 1.0, 1.0), second(-0.22, 1.0, 1.0), second(0.0, 1.1, 1.0)], [None; 3]);
    assert_eq!([second(0.25, 1.0, 1.0), second(-0.25, 1.0, 1.0)], [Some(1); 2]);
    // A clamped capacitance that changed in the pause is not a failure.
    assert_eq!([second(0.0, 1.0, 2.0), second(0.0, 1.0, 0.5)], [None; 2]);
}
