//! Bursts, checked to the sample: a burst plays the uninterrupted wave times the envelope, and its
//! voltage integral is zero.

use firmware::seam::config::{Config, Edge, Schedule, ShapeKind};
use hal_mock::bench::Setup;

use super::*;

/// Windows in samples: their ends are inside blocks, and at the edge of a block.
const WINDOWS: [(usize, usize); 3] = [(5003, 6217), (6400, 6432), (8001, 8100)];
const BLOCKS: u64 = 300;
/// Half a period of 40.4 kHz in samples, rounded up.
const HALF_PERIOD_SAMPLES: usize = 13;
/// Largest correction of the voltage integral in a sample, codes.
const MAX_CORRECTION_CODES: i32 = 32;

/// Returns a setup with the windows and edges of this kind; soft ones take this number of periods.
fn windowed((edge, cycles): (Edge, f32), change: impl FnOnce(&mut Config)) -> Setup {
    setup(|config| {
        let seconds = |samples: usize| samples as f64 * 1e-6;
        config.burst.schedule = Schedule::Windows(WINDOWS.iter().map(|&(on, off)| (seconds(on), seconds(off))).collect());
        (config.burst.edge, config.burst.edge_cycles) = (edge, cycles);
        change(config);
    })
}

fn about_zero(code: u16) -> i32 {
    i32::from(code) - i32::from(MID_CODE)
}

/// Returns the codes of every lane of a run with its windows, and of the same run without them.
fn with_and_without(edge: (Edge, f32), change: fn(&mut Config)) -> Vec<(Vec<u16>, Vec<u16>)> {
    let lanes = |setup: &Setup| {
        let mut queues = Queues::default();
        let mut bench = ordered_to_run_with(&mut queues, setup, &[]);
        bench.blocks(BLOCKS);
        (0..usize::from(setup.config.lanes)).map(|lane| played(&mut bench, lane)).collect::<Vec<_>>()
    };
    lanes(&windowed(edge, change)).into_iter().zip(lanes(&setup(change))).collect()
}

/// Returns the first and the last played sample of a window, whole periods of the first lane.
fn sounding(burst: &[u16], whole: &[u16], (on, off): (usize, usize)) -> (usize, usize) {
    let first = (on..on + 2 * HALF_PERIOD_SAMPLES).find(|&n| about_zero(burst[n]).abs() > MAX_CORRECTION_CODES).unwrap();
    let last = (off..off + 3 * HALF_PERIOD_SAMPLES)
        .rfind(|&n| burst[n] == whole[n] && about_zero(burst[n]).abs() > MAX_CORRECTION_CODES)
        .unwrap_or(off);
    (first, last)
}

#[test]
fn hard_bursts_play_whole_periods_of_the_uninterrupted_wave() {
    let lanes = with_and_without((Edge::Hard, 0.5), |_| ());
    let (burst, whole) = &lanes[0];
    for window in WINDOWS {
        let (first, last) = sounding(burst, whole, window);
        assert!((first..=last).all(|n| burst[n] == whole[n]), "{window:?}");
        // It begins at a zero crossing: within one sample the wave is as small as possible.
        let begins = (first - 1..=first).any(|n| about_zero(whole[n - 1]).signum() != about_zero(whole[n]).signum());
        assert!(begins && first < window.0 + HALF_PERIOD_SAMPLES + 1, "{window:?} begins at {first}");
        let periods = (last + 1 - first) as f64 * 40_400e-6;
        assert!(
            (periods - periods.round()).abs() < 0.09 && last < window.1 + 2 * HALF_PERIOD_SAMPLES,
            "{window:?}: {periods} periods"
        );
    }
}

#[test]
fn the_voltage_integral_of_a_burst_is_zero() {
    let cases: [fn(&mut Config); 4] = [
        |_| (),
        |config| config.lanes = 4,
        |config| {
            config.drive.shape = ShapeKind::Sawtooth;
            config.drive.dither = true;
        },
        |config| config.drive.shape = ShapeKind::Noise,
    ];
    for edge in [(Edge::Hard, 0.5), (Edge::Soft, 1.5)] {
        for change in cases {
            for (burst, _) in with_and_without(edge, change) {
                for (n, window) in WINDOWS.iter().enumerate() {
                    let next = WINDOWS.get(n + 1).map_or(BLOCKS as usize * BLOCK, |next| next.0);
                    let sum: i32 = burst[window.0..next].iter().map(|&code| about_zero(code)).sum();
                    assert_eq!(sum, 0, "{edge:?} {window:?}");
                    // The correction is small and ends.
                    assert!(burst[next - BLOCK..next].iter().all(|&code| code == MID_CODE), "{edge:?} {window:?}");
                }
            }
        }
    }
}

#[test]
fn soft_windows_rise_and_fall_along_a_raised_cosine() {
    let lanes = with_and_without((Edge::Soft, 4.0), |_| ());
    let (burst, whole) = &lanes[0];
    // The edge takes four periods of 40.4 kHz; the ramp moves one step per sample.
    let (edge, mut ramp) = (99_i32, 0_i32);
    for n in 4000..burst.len() {
        let on = WINDOWS.iter().any(|window| (window.0..window.1).contains(&n));
        ramp = (ramp + if on { 1 } else { -1 }).clamp(0, edge);
        if ramp == 0 {
            assert!(about_zero(burst[n]).abs() <= MAX_CORRECTION_CODES);
            continue;
        }
        let envelope = 0.5 - 0.5 * (std::f64::consts::PI * f64::from(ramp) / f64::from(edge)).cos();
        let (got, expected) = (f64::from(about_zero(burst[n])), envelope * f64::from(about_zero(whole[n])));
        assert!((got - expected).abs() <= 1.01, "sample {n}: {got} for {expected}");
    }
}

#[test]
fn a_periodic_burst_keeps_its_period_from_the_order_on() {
    let (period, on) = (417, 100);
    let periodic = setup(|config| config.burst.schedule = Schedule::Periodic { period_s: 417e-6, duty: 0.24 });
    let (burst, whole) = (codes_of_run(&periodic, BLOCKS), codes_of_run(&Setup::default(), BLOCKS));
    for n in 4100..burst.len() {
        // Within half a period of the start, or up to one period after the end, both values are
        // right.
        match n % period {
            0..HALF_PERIOD_SAMPLES => {}
            phase if phase < on => assert_eq!(burst[n], whole[n], "sample {n}"),
            phase if phase < on + 2 * HALF_PERIOD_SAMPLES => {}
            _ => assert!(about_zero(burst[n]).abs() <= MAX_CORRECTION_CODES, "sample {n}"),
        }
    }
}

/// Returns the samples at which the drive begins after two periods of silence.
fn beginnings(codes: &[u16]) -> Vec<usize> {
    let sounding = codes.iter().enumerate().filter(|(_, code)| about_zero(**code).abs() > MAX_CORRECTION_CODES).map(|(n, _)| n);
    let mut before = None;
    sounding.filter(|&n| before.replace(n).is_none_or(|before| n - before > 4 * HALF_PERIOD_SAMPLES)).collect()
}

#[test]
fn a_schedule_counts_from_the_order_to_run() {
    /// Not a whole number of the periods below.
    const IDLE_BLOCKS: u64 = 41;
    let periodic = setup(|config| config.burst.schedule = Schedule::Periodic { period_s: 417e-6, duty: 0.24 });
    for setup in [windowed((Edge::Hard, 0.5), |_| ()), periodic] {
        let at_once = beginnings(&codes_of_run(&setup, BLOCKS));
        let mut queues = Queues::default();
        let mut bench = bench(&mut queues, &setup);
        // The first pass follows silence, the second a run.
        for _ in 0..2 {
            bench.ask(Command::Idle);
            bench.blocks(IDLE_BLOCKS);
            let silent = played(&mut bench, 0).len();
            assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
            bench.blocks(BLOCKS);
            let begins = beginnings(&played(&mut bench, 0)[silent..]);
            let near = |(a, b): (&usize, &usize)| a.abs_diff(*b) <= HALF_PERIOD_SAMPLES + 1;
            assert!(begins.len() == at_once.len() && begins.iter().zip(&at_once).all(near), "{begins:?}, {at_once:?}");
        }
    }
}
