//! Bursts, to the sample: a burst run plays what an uninterrupted run plays, times the envelope.

use firmware::config::{Edge, Schedule};
use hal_mock::bench::Setup;

use super::*;

/// Samples of the windows: ends inside blocks, at a block's edge, and one of a single sample.
const WINDOWS: [(usize, usize); 3] = [(5003, 6217), (6400, 6432), (8001, 8002)];
const BLOCKS: u64 = 300;

fn windowed(edge: Edge) -> Setup {
    setup(|config| {
        let seconds = |samples: usize| samples as f64 * 1e-6;
        config.burst.schedule = Schedule::Windows(WINDOWS.iter().map(|&(on, off)| (seconds(on), seconds(off))).collect());
        config.burst.edge = edge;
    })
}

/// Samples that belong to the run, and not to its self-test.
fn of_run(codes: Vec<u16>) -> impl Iterator<Item = (usize, u16)> {
    codes.into_iter().enumerate().skip(4000)
}

#[test]
fn hard_windows_play_exactly_their_samples() {
    let whole = codes_of_run(&Setup::default(), BLOCKS);
    let got = codes_of_run(&windowed(Edge::Hard), BLOCKS);
    let on = |n: usize| WINDOWS.iter().any(|window| (window.0..window.1).contains(&n));
    for (n, code) in of_run(got.clone()) {
        assert_eq!(code, if on(n) { whole[n] } else { MID }, "sample {n}");
    }
    // The sine passes through zero once in a while, but not more often.
    let sounding = of_run(got).filter(|&(_, code)| code != MID).count();
    let scheduled: usize = WINDOWS.iter().map(|window| window.1 - window.0).sum();
    assert!((scheduled - 12..=scheduled).contains(&sounding), "{sounding} of {scheduled}");
}

#[test]
fn soft_windows_rise_and_fall_along_a_raised_cosine() {
    let whole = codes_of_run(&Setup::default(), BLOCKS);
    let got = codes_of_run(&windowed(Edge::Soft { cycles: 4.0 }), BLOCKS);
    // Four periods of 40.4 kHz, and the ramp moves one step a sample.
    let (edge, mut ramp) = (99_i32, 0_i32);
    for (n, code) in of_run(got) {
        let on = WINDOWS.iter().any(|window| (window.0..window.1).contains(&n));
        ramp = (ramp + if on { 1 } else { -1 }).clamp(0, edge);
        let envelope = 0.5 - 0.5 * (std::f64::consts::PI * f64::from(ramp) / f64::from(edge)).cos();
        let expected = envelope * (f64::from(whole[n]) - f64::from(MID));
        let got = f64::from(code) - f64::from(MID);
        assert!((got - expected).abs() <= 1.01, "sample {n}: {got} for {expected}");
    }
}

#[test]
fn a_periodic_burst_keeps_its_period_from_the_first_sample_on() {
    let (period, on) = (417, 100);
    let periodic = setup(|config| config.burst.schedule = Schedule::Periodic { period_s: 417e-6, duty: 0.24 });
    let whole = codes_of_run(&Setup::default(), BLOCKS);
    for (n, code) in of_run(codes_of_run(&periodic, BLOCKS)) {
        assert_eq!(code, if n % period < on { whole[n] } else { MID }, "sample {n}");
    }
}
