//! Tests of the loop on a current that follows its voltage with the lag of a resonance.

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
    AmplitudeLoop {
        most_volts: 12.0,
        voltage_limit: 12.0,
        least_volts: 1e-4,
        start_volts: 1.0,
        block_s: 32e-6,
        ohm: 0.0,
        lag: 0.0,
        expected: amperes,
        integral_volts: 1.0,
        set_point: 0.0,
        stepped: false,
        volts: 1.0,
        limited: false,
        fold_back: FoldBack::build(3.0),
        rise: 1.0,
        risen: 0.0,
        rises_from_a: 0.0,
        settled_blocks: 0,
        last_set_point_a: 0.0,
    }
}

#[test]
fn holds_the_current_when_the_load_triples_the_resistance() {
    let mut hold = amplitude_loop(1.0);
    hold.seed(&transducer(65.0, 3.0), 0.0, 1.0);
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

/// A new amplitude takes only the ring-up, for any load that the loop has found before. Measured:
/// 0.7 % off after five time constants.
#[test]
fn a_new_amplitude_takes_only_the_ring_up() {
    let mut hold = amplitude_loop(1.0);
    hold.seed(&transducer(65.0, 3.0), 0.0, 1.0);
    let lag = 32e-6 * core::f32::consts::PI * 40e3 / 65.0;
    let mut current = 0.0;
    for set_point in [1.0, 0.4, 0.9] {
        let blocks = if set_point == 1.0 { 2000 } else { 80 };
        for _ in 0..blocks {
            current += lag * (hold.volts() / 3.6 - current);
            hold.update(Amplitude::MotionalCurrent(set_point), 1.0, current.into());
        }
        assert!((current / set_point - 1.0).abs() < 0.01, "{set_point}: {current}");
    }
}

/// The amplitude returns after a set point of zero, or one that fades into the noise.
#[test]
fn the_amplitude_returns_after_zero() {
    let lag = 32e-6 * core::f32::consts::PI * 40e3 / 65.0;
    let none = |_: usize| 0.0;
    let fading = |n: usize| libm::powf(0.5, n as f32 / 20.0);
    let (nothing, faded): (&dyn Fn(usize) -> f32, &dyn Fn(usize) -> f32) = (&none, &fading);
    // After zero, only the ring-up takes time; after fading, the loop must find the load again.
    for (course, blocks) in [(nothing, 80), (faded, 600)] {
        let mut hold = amplitude_loop(1.0);
        hold.seed(&transducer(65.0, 3.0), 0.0, 1.0);
        let mut current = 0.0;
        for n in 0..4000 + blocks {
            let set_point = if (2000..4000).contains(&n) { course(n - 2000) } else { 1.0 };
            current += lag * (hold.volts() / 3.6 - current);
            // Silence has no envelope, and a current below its noise reads as the noise.
            let noise = 1e-3;
            let envelope = if hold.volts() > 0.0 { 1.0 } else { 0.0 };
            hold.update(Amplitude::MotionalCurrent(set_point), envelope, larger(current, noise).into());
            assert!(!(3990..4000).contains(&n) || hold.volts() == 0.0, "{n}: {}", hold.volts());
        }
        assert!((current - 1.0).abs() < 0.01, "{current}");
    }
}

/// The amplitude rises along a straight line, from the voltage or the current at its beginning.
#[test]
fn a_soft_start_rises_along_a_line() {
    for (set_point, from, to) in [(Amplitude::Volts(5.0), 1.0, 5.0), (Amplitude::Volts(0.5), 0.5, 0.5)] {
        let mut hold = AmplitudeLoop { rise: 0.01, ..amplitude_loop(1.0) };
        hold.seed(&transducer(65.0, 3.0), 0.0, 1.0);
        for n in 1..200 {
            hold.update(set_point, 1.0, Phasor::default());
            let part = (n as f32 * 0.01).min(1.0);
            assert!((hold.volts() - (from + part * (to - from))).abs() < 1e-4, "{n}: {}", hold.volts());
        }
    }
    let mut hold = AmplitudeLoop { rise: 1e-3, ..amplitude_loop(1.0) };
    hold.seed(&transducer(65.0, 3.0), 0.2, 1.0);
    let (lag, mut current) = (32e-6 * core::f32::consts::PI * 40e3 / 65.0, 0.2);
    for n in 1..=1200 {
        current += lag * (hold.volts() / 3.0 - current);
        hold.update(Amplitude::MotionalCurrent(1.0), 1.0, current.into());
        let line = 0.2 + 0.8 * (n as f32 * 1e-3).min(1.0);
        // The current lags the set point by the ring-up, 16 blocks. Meanwhile the loop, with a time
        // constant of 83 blocks, finds the load.
        assert!(n < 250 || (current - line).abs() < 0.03, "{n}: {current} for {line}");
    }
}

/// A drive below the resolution of the converter is silence, so that its multiples stay finite.
#[test]
fn an_amplitude_below_the_resolution_is_silence() {
    let mut hold = amplitude_loop(1.0);
    hold.seed(&transducer(65.0, 3.0), 0.0, 1.0);
    for (set_point, played) in [(1e-3, 1e-3), (1e-4, 1e-4), (0.9e-4, 0.0), (1e-30, 0.0), (1e-45, 0.0)] {
        hold.update(Amplitude::Volts(set_point), 1.0, Phasor::default());
        assert_eq!(hold.volts(), played, "{set_point:e}");
        assert!((1.0..=12.0 / 1e-4).contains(&hold.headroom()), "{set_point:e}: {}", hold.headroom());
    }
}

#[test]
fn the_limit_is_never_exceeded_and_is_reported() {
    let mut hold = amplitude_loop(2.0);
    hold.seed(&transducer(65.0, 3.0), 0.0, 1.0);
    for set_point in [Amplitude::Volts(50.0), Amplitude::Volts(f32::INFINITY)] {
        hold.update(set_point, 1.0, Phasor::default());
        assert!(hold.volts() == 12.0 && hold.limited(), "{set_point:?}");
    }
    for set_point in [Amplitude::Volts(-3.0), Amplitude::Volts(f32::NAN)] {
        hold.update(set_point, 1.0, Phasor::default());
        assert_eq!(hold.volts(), 0.0, "{set_point:?}");
    }
    for current in [f32::NAN, f32::INFINITY, 0.0] {
        hold.expected = 0.0;
        hold.update(Amplitude::MotionalCurrent(f32::NAN), 1.0, current.into());
        assert!(hold.volts() <= 1.0, "{current}: {}", hold.volts());
    }
    hold.update(Amplitude::MotionalCurrent(2.0), 1.0, f32::NAN.into());
    assert!(hold.volts() <= 12.0);
}

/// A step of 0.3 % ends a measurement of the clamped branch; one of 0.03 % does not.
#[test]
fn a_changed_set_point_is_a_step() {
    let mut hold = amplitude_loop(1.0);
    let stepped = [3.0, 3.0, 3.001, 3.01, 3.01].map(|volts| {
        hold.update(Amplitude::Volts(volts), 1.0, Phasor::default());
        hold.is_stepped()
    });
    assert_eq!(stepped, [true, false, false, true, false]);
}
