//! The loop against a current that follows its voltage with the lag of a resonance.

use super::*;

fn transducer(q: f32, rm_ohm: f32) -> Transducer {
    Transducer {
        series_resonance_hz: 40e3,
        parallel_resonance_hz: 41.3e3,
        q,
        rm_ohm,
        lm_h: 0.79e-3,
        cm_f: 20e-9,
        c0_f: 300e-9,
        ..Transducer::default()
    }
}

fn amplitude_loop(amperes: f32) -> AmplitudeLoop {
    let limits = Limits { voltage_v: 12.0, current_a: 3.0, ..Limits::default() };
    AmplitudeLoop {
        limits,
        voltage_limit: 12.0,
        least_volts: 1e-4,
        start_volts: 1.0,
        block_s: 32e-6,
        ohm: 0.0,
        lag: 0.0,
        expected: amperes,
        integral_volts: 1.0,
        volts: 1.0,
        limited: false,
        fold_back: FoldBack::build(3.0),
        rise: 1.0,
        risen: 0.0,
        rises_from_a: 0.0,
        within: 0,
        asked: 0.0,
    }
}

#[test]
fn holds_the_current_when_the_load_triples_the_resistance() {
    let mut hold = amplitude_loop(1.0);
    hold.seed(&transducer(65.0, 3.0), 0.0);
    let mut current = 0.0;
    for n in 0..4000 {
        let (ohm, q) = if n < 2000 { (3.0, 65.0) } else { (9.0, 22.0) };
        let lag = 32e-6 * core::f32::consts::PI * 40e3 / q;
        current += lag * (hold.volts() / ohm - current);
        hold.update(Amplitude::MotionalCurrent(1.0), 1.0, current.into());
        if n == 1999 {
            assert!((current - 1.0).abs() < 1e-3 && (hold.volts() - 3.0).abs() < 1e-2, "{current} {}", hold.volts());
        }
    }
    assert!((current - 1.0).abs() < 1e-3, "{current}");
}

/// Another amplitude is there as soon as the stack has rung to it, whatever the load is that the loop has found before. Measured: 0.7 %
/// off after five time constants.
#[test]
fn a_new_amplitude_takes_as_long_as_the_ring() {
    let mut hold = amplitude_loop(1.0);
    hold.seed(&transducer(65.0, 3.0), 0.0);
    let lag = 32e-6 * core::f32::consts::PI * 40e3 / 65.0;
    let mut current = 0.0;
    for asked in [1.0, 0.4, 0.9] {
        let blocks = if asked == 1.0 { 2000 } else { 80 };
        for _ in 0..blocks {
            current += lag * (hold.volts() / 3.6 - current);
            hold.update(Amplitude::MotionalCurrent(asked), 1.0, current.into());
        }
        assert!((current / asked - 1.0).abs() < 0.01, "{asked}: {current}");
    }
}

/// Silence, by an order of no current or of one that fades into the noise, is over with the next order: what was known of the load is still known.
#[test]
fn an_amplitude_that_was_nothing_comes_back() {
    let lag = 32e-6 * core::f32::consts::PI * 40e3 / 65.0;
    let none = |_: usize| 0.0;
    let fading = |n: usize| libm::powf(0.5, n as f32 / 20.0);
    let (nothing, faded): (&dyn Fn(usize) -> f32, &dyn Fn(usize) -> f32) = (&none, &fading);
    // After an order of none it is there as soon as the stack has rung to it; what has faded into the noise has to be found again.
    for (course, blocks) in [(nothing, 80), (faded, 600)] {
        let mut hold = amplitude_loop(1.0);
        hold.seed(&transducer(65.0, 3.0), 0.0);
        let mut current = 0.0;
        for n in 0..4000 + blocks {
            let asked = if (2000..4000).contains(&n) { course(n - 2000) } else { 1.0 };
            current += lag * (hold.volts() / 3.6 - current);
            // What is silent has no envelope, and a current that is less than its noise is that.
            let noise = 1e-3;
            let envelope = if hold.volts() > 0.0 { 1.0 } else { 0.0 };
            hold.update(Amplitude::MotionalCurrent(asked), envelope, larger(current, noise).into());
            assert!(!(3990..4000).contains(&n) || hold.volts() == 0.0, "{n}: {}", hold.volts());
        }
        assert!((current - 1.0).abs() < 0.01, "{current}");
    }
}

/// From the voltage, or the current, that it starts with, along a straight line.
#[test]
fn a_soft_start_rises_along_a_line() {
    for (asked, from, to) in [(Amplitude::Volts(5.0), 1.0, 5.0), (Amplitude::Volts(0.5), 0.5, 0.5)] {
        let mut hold = AmplitudeLoop { rise: 0.01, ..amplitude_loop(1.0) };
        hold.seed(&transducer(65.0, 3.0), 0.0);
        for n in 1..200 {
            hold.update(asked, 1.0, Phasor::default());
            let part = (n as f32 * 0.01).min(1.0);
            assert!((hold.volts() - (from + part * (to - from))).abs() < 1e-4, "{n}: {}", hold.volts());
        }
    }
    let mut hold = AmplitudeLoop { rise: 1e-3, ..amplitude_loop(1.0) };
    hold.seed(&transducer(65.0, 3.0), 0.2);
    let (lag, mut current) = (32e-6 * core::f32::consts::PI * 40e3 / 65.0, 0.2);
    for n in 1..=1200 {
        current += lag * (hold.volts() / 3.0 - current);
        hold.update(Amplitude::MotionalCurrent(1.0), 1.0, current.into());
        let line = 0.2 + 0.8 * (n as f32 * 1e-3).min(1.0);
        // It lags by the ring-up, 16 blocks; the loop, whose time constant is 83 blocks, finds the load on the way.
        assert!(n < 250 || (current - line).abs() < 0.03, "{n}: {current} for {line}");
    }
}

/// What the converter cannot show is silence, so that no multiple of a drive is without an end.
#[test]
fn an_amplitude_that_is_next_to_nothing_is_nothing() {
    let mut hold = amplitude_loop(1.0);
    hold.seed(&transducer(65.0, 3.0), 0.0);
    for (asked, played) in [(1e-3, 1e-3), (1e-4, 1e-4), (0.9e-4, 0.0), (1e-30, 0.0), (1e-45, 0.0)] {
        hold.update(Amplitude::Volts(asked), 1.0, Phasor::default());
        assert_eq!(hold.volts(), played, "{asked:e}");
        assert!((1.0..=12.0 / 1e-4).contains(&hold.headroom()), "{asked:e}: {}", hold.headroom());
    }
}

#[test]
fn the_limit_is_never_exceeded_and_says_so() {
    let mut hold = amplitude_loop(2.0);
    hold.seed(&transducer(65.0, 3.0), 0.0);
    for asked in [Amplitude::Volts(50.0), Amplitude::Volts(f32::INFINITY)] {
        hold.update(asked, 1.0, Phasor::default());
        assert!(hold.volts() == 12.0 && hold.limited(), "{asked:?}");
    }
    for asked in [Amplitude::Volts(-3.0), Amplitude::Volts(f32::NAN)] {
        hold.update(asked, 1.0, Phasor::default());
        assert_eq!(hold.volts(), 0.0, "{asked:?}");
    }
    for current in [f32::NAN, f32::INFINITY, 0.0] {
        hold.expected = 0.0;
        hold.update(Amplitude::MotionalCurrent(f32::NAN), 1.0, current.into());
        assert!(hold.volts() <= 1.0, "{current}: {}", hold.volts());
    }
    hold.update(Amplitude::MotionalCurrent(2.0), 1.0, f32::NAN.into());
    assert!(hold.volts() <= 12.0);
}
