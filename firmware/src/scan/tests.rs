//! Scans of the exact bench, over Q, window and noise.

use super::bench::{Bench, Branch, front_end};
use super::*;
use crate::block::Amplitude;
use crate::block::{DriveBlock, LATENCY_BLOCKS};
use crate::config;
use crate::config::{Drive, FrontEnd, Limits, Phasing, Tracking, TrackingMode};
use crate::demod::demodulate;
use crate::nco::{Nco, Stretch};
use crate::shape::sine;
use std::vec::Vec as List;

const SAMPLES: usize = 32;

/// What is scanned, and what is told of it.
struct Case {
    branches: List<Branch>,
    c0_f: f64,
    nominal_hz: f32,
    nominal_q: f32,
    told_c0: f32,
    nominal_lm_h: Option<f32>,
    span: f32,
    volts: f32,
    noise_lsb: f64,
    front_end: FrontEnd,
}

/// Set A of the flagship stack at some Q.
fn stack(hz: f64, q: f64) -> Case {
    Case {
        branches: std::vec![Branch { hz, q, lm_h: 791.6e-6 }],
        c0_f: 300e-9,
        nominal_hz: 40e3,
        nominal_q: 65.0,
        told_c0: 0.95 * 300e-9,
        nominal_lm_h: None,
        span: 0.025,
        volts: 3.0,
        noise_lsb: 1.0,
        front_end: front_end(),
    }
}

struct Scanned {
    found: Result<(Transducer, Motional), Fault>,
    list: Resonances,
    /// Until the window is searched, and until the end, s.
    searched_s: f32,
    ended_s: f32,
    fine_s: f32,
    first: Option<Transducer>,
}

fn scan(case: &Case, seed: u64) -> Scanned {
    let config = config::Config {
        sample_hz: 1e6,
        block_samples: SAMPLES as u16,
        lanes: 1,
        front_end: case.front_end.clone(),
        drive: Drive::sine(case.nominal_hz, Amplitude::Volts(case.volts), case.volts),
        sweep: config::Sweep::Hold,
        phasing: Phasing::default(),
        burst: config::Burst { schedule: config::Schedule::Continuous, edge: config::Edge::Hard, brake: false },
        tracking: Tracking {
            mode: TrackingMode::PhaseLock,
            span: case.span,
            bandwidth_hz: 200.0,
            nominal_q: case.nominal_q,
            nominal_lm_h: case.nominal_lm_h,
            nominal_c0_f: case.told_c0,
        },
        limits: Limits { voltage_v: 15.0, current_a: 4.0, belt_moving_m_per_s: 1e-3, belt_stop_ms: 5.0 },
    };
    let convert = Convert::build(&case.front_end).unwrap();
    let mut bench = Bench::new(&case.branches, case.c0_f, seed, case.front_end.clone());
    bench.noise_lsb = case.noise_lsb;
    let mut scan = Scan::build(&config).unwrap();
    let (mut hold, mut nco) = (Hold::build(case.nominal_hz, 1e6).unwrap(), Nco::default());
    let silence = (Stretch { word: hold.word(), ..Stretch::default() }, DriveBlock::silent(1, SAMPLES, 2048));
    let mut playing = [silence.clone(), silence];
    let mut sense = SenseBlock::default();
    let mut result = Scanned {
        found: Err(Fault::EmergencyStop),
        list: Resonances::new(),
        searched_s: 0.0,
        ended_s: 0.0,
        fine_s: 0.0,
        first: None,
    };
    for block in 0..40_000 {
        let slot = block % LATENCY_BLOCKS;
        bench.exchange(&playing[slot].1, &mut sense);
        let sensed = demodulate(&convert, &sense, &playing[slot].0).0;
        let before = scan.stage;
        let step = scan.step(&convert, &sense, &sensed);
        let now_s = (block + 1) as f32 * 32e-6;
        if matches!(before, Stage::Search(_)) && !matches!(scan.stage, Stage::Search(_) | Stage::Window(_)) {
            result.searched_s = now_s;
            if let Some(found) = scan.found.get(scan.chosen) {
                let deviations = found.1;
                let place = scan.search.found().0.poles.iter().position(|pole| *pole == found.0).unwrap_or(0);
                result.first = Some(Transducer { deviations, ..scan.search.found().0.transducer(place) });
            }
        }
        if matches!(scan.stage, Stage::Fine) {
            result.fine_s = scan.pass.blocks() as f32 * 32e-6;
        }
        let done = match step {
            Step::Tune(offset_hz) => {
                hold.retune(offset_hz);
                false
            }
            Step::Found(transducer, motional) => {
                result.found = Ok((transducer, motional));
                true
            }
            Step::Failed(fault) => {
                result.found = Err(fault);
                true
            }
        };
        result.ended_s = now_s;
        if done {
            break;
        }
        let stretch = nco.advance((hold.word(), 0), SAMPLES);
        let code = |n: usize| {
            let volts = case.volts * sine::rotation(stretch.phase_at(n)).re;
            (2048.5 + volts / case.front_end.drive_volt_per_lsb) as u16
        };
        playing[slot] = (stretch, DriveBlock::silent(1, SAMPLES, 0));
        for n in 0..SAMPLES {
            playing[slot].1.lanes[0][n] = code(n);
        }
    }
    result.list = scan.resonances().iter().copied().collect();
    result
}

#[test]
#[ignore]
fn explore() {
    for span in [0.025, 0.05] {
        for q in [20.0, 40.0, 65.0, 200.0, 500.0, 1600.0] {
            for hz in [39_300.0, 40_020.0, 40_700.0] {
                let mut case = stack(hz, q);
                case.span = span;
                let got = scan(&case, 1);
                let first = got.first.map(|t| {
                    (
                        f64::from(t.series_resonance_hz) - hz,
                        t.deviations.series_resonance_hz,
                        100.0 * (f64::from(t.q) / q - 1.0),
                        100.0 * t.deviations.q / t.q,
                        100.0 * (f64::from(t.c0_f) / 300e-9 - 1.0),
                    )
                });
                std::println!(
                    "{span} Q {q} {hz}: modes {} searched {:.1} ms fine {:.1} end {:.1} first {:.3?}",
                    got.list.len(),
                    1e3 * got.searched_s,
                    1e3 * got.fine_s,
                    1e3 * got.ended_s,
                    first
                );
                match got.found {
                    Ok((t, m)) => std::println!(
                        "      df {:.3} sd {:.3}  dQ {:.3} % sd {:.3}  dLm {:.3} % sd {:.3} dC0 {:.3} % sd {:.3} g0 {:.5} axis {:.5}",
                        f64::from(t.series_resonance_hz) - hz,
                        t.deviations.series_resonance_hz,
                        100.0 * (f64::from(t.q) / q - 1.0),
                        100.0 * t.deviations.q / t.q,
                        100.0 * (f64::from(t.lm_h) / 791.6e-6 - 1.0),
                        100.0 * t.deviations.lm_h / t.lm_h,
                        100.0 * (f64::from(t.c0_f) / 300e-9 - 1.0),
                        100.0 * t.deviations.c0_f / t.c0_f,
                        m.y0.re,
                        m.axis.im
                    ),
                    Err(fault) => std::println!("      {fault:?}"),
                }
            }
        }
    }
}

/// Mean and standard deviation.
fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (mean, libm::sqrt(values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0)))
}

fn welder(hz: f64, q: f64) -> Case {
    let front_end = FrontEnd { ampere_per_lsb: 0.5 / 2048.0, ..front_end() };
    Case {
        branches: std::vec![Branch { hz, q, lm_h: 316.6e-3 }],
        c0_f: 10e-9,
        nominal_hz: 20e3,
        nominal_q: 500.0,
        told_c0: 10.4e-9,
        volts: 10.0,
        front_end,
        ..stack(hz, q)
    }
}

fn ratios(case: &Case, seeds: u64, of: impl Fn(&Scanned) -> Option<Transducer>) -> List<(f64, f64, f64, f64)> {
    let branch = case.branches[0];
    let (cm, c0) = (branch.cm_f(), case.c0_f);
    let truth = [
        branch.hz,
        branch.hz * libm::sqrt(1.0 + cm / c0),
        branch.q,
        branch.rm_ohm(),
        branch.lm_h,
        cm,
        c0,
        libm::sqrt(cm / (c0 + cm)),
    ];
    let mut all: [List<f64>; 8] = Default::default();
    let mut errors: [List<f64>; 8] = Default::default();
    let mut sds: [f64; 8] = [0.0; 8];
    for seed in 1..=seeds {
        let Some(t) = of(&scan(case, seed)) else {
            std::println!("none, seed {seed}");
            continue;
        };
        let d = t.deviations;
        let got = [t.series_resonance_hz, t.parallel_resonance_hz, t.q, t.rm_ohm, t.lm_h, t.cm_f, t.c0_f, t.coupling];
        let sd = [d.series_resonance_hz, d.parallel_resonance_hz, d.q, d.rm_ohm, d.lm_h, d.cm_f, d.c0_f, d.coupling];
        for n in 0..8 {
            all[n].push((f64::from(got[n]) - truth[n]) / f64::from(sd[n]));
            errors[n].push(f64::from(got[n]) - truth[n]);
            sds[n] += f64::from(sd[n]) / seeds as f64;
        }
    }
    (0..8)
        .map(|n| {
            let (m, s) = moments(&errors[n]);
            (
                moments(&all[n].iter().zip(&errors[n]).map(|(a, e)| a * (e - m) / e).collect::<List<_>>()).1,
                m / truth[n],
                s / truth[n],
                sds[n] / truth[n],
            )
        })
        .collect()
}

#[test]
#[ignore]
fn explore_deviations() {
    for (name, case) in [
        ("40k Q20", stack(40_300.0, 20.0)),
        ("Q65", stack(40_300.0, 65.0)),
        ("Q500", stack(40_300.0, 500.0)),
        ("20k Q57", welder(20_100.0, 57.0)),
        ("20k Q1592", welder(20_100.0, 1592.0)),
        ("20k 19.7 Q1592", welder(19_700.0, 1592.0)),
    ] {
        for (which, r) in
            [("window", ratios(&case, 100, |s| s.first)), ("final", ratios(&case, 100, |s| s.found.as_ref().ok().map(|f| f.0)))]
        {
            std::print!("{name} {which}: ratio");
            for x in &r {
                std::print!(" {:.2}", x.0);
            }
            std::println!();
            for (n, x) in ["fs", "fp", "Q", "Rm", "Lm", "Cm", "C0", "k"].iter().zip(&r) {
                std::print!("  {n} bias {:.1e} sd {:.1e} stated {:.1e};", x.1, x.2, x.3);
            }
            std::println!();
        }
    }
}

#[test]
#[ignore]
fn explore_modes() {
    for q in [20.0, 65.0, 200.0] {
        for (second, factor) in
            [(41_500.0, 3.3), (41_500.0, 10.0), (38_800.0, 3.3), (40_700.0, 10.0), (42_800.0, 3.3), (42_800.0, 10.0)]
        {
            let mut case = stack(40_100.0, q);
            case.span = 0.05;
            case.branches.push(Branch { hz: second, q: 1.5 * q, lm_h: 791.6e-6 * factor });
            for seed in 1..4 {
                let got = scan(&case, seed);
                std::println!(
                    "Q {q} second {second} x{factor}: searched {:.1} end {:.1} {:?}",
                    1e3 * got.searched_s,
                    1e3 * got.ended_s,
                    got.list.iter().map(|r| (r.hz, r.q, r.lm_h * 1e3)).collect::<List<_>>()
                );
                match got.found {
                    Ok((t, m)) => std::println!(
                        "    df {:.3} sd {:.3} Q {:.2} % sd {:.2} Lm {:.2} % C0 {:.2} % y0 {:.5}",
                        t.series_resonance_hz - 40100.0,
                        t.deviations.series_resonance_hz,
                        100.0 * (t.q / q as f32 - 1.0),
                        100.0 * t.deviations.q / t.q,
                        100.0 * (t.lm_h / 791.6e-6 - 1.0),
                        100.0 * (t.c0_f / 300e-9 - 1.0),
                        m.y0.re
                    ),
                    Err(f) => std::println!("    {f:?}"),
                }
            }
        }
    }
}

#[test]
#[ignore]
fn explore_nothing() {
    for seed in 1..40 {
        let mut case = stack(40_100.0, 65.0);
        case.span = if seed % 2 == 0 { 0.025 } else { 0.05 };
        case.branches[0].lm_h = 1e4;
        let got = scan(&case, seed);
        std::println!("{:?} {:?} ended {}", got.list, got.found.is_ok(), got.ended_s);
    }
    for hz in [38_000.0, 42_000.0, 41_050.0, 38_900.0, 44_000.0, 36_000.0] {
        for q in [20.0, 65.0, 200.0] {
            let got = scan(&stack(hz, q), 3);
            std::println!("outside {hz} Q {q}: {:?} {:?}", got.list, got.found.map(|f| f.0.series_resonance_hz));
        }
    }
}
