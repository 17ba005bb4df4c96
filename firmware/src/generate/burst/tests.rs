mod schedule;

use super::*;
use crate::generate::nco::tuning_word;
use crate::seam::config::Schedule as ScheduleConfig;

/// Returns a burst in which a soft edge takes one period.
fn burst(schedule: ScheduleConfig, edge: Edge) -> Burst {
    Burst::build(&Config { schedule, edge, edge_cycles: 1.0, brake: false }, 40e3, 1e6).unwrap()
}

fn window(on_s: f64, off_s: f64) -> ScheduleConfig {
    ScheduleConfig::Windows([(on_s, off_s)].into_iter().collect())
}

/// Returns a tone whose period is 24.75 samples, from phase zero at sample zero.
fn tone(now: u64) -> Stretch {
    let word = tuning_word(40_404.0 / 1e6);
    Stretch { phase: word.wrapping_mul(now), word, step: 0 }
}

fn levels(burst: &mut Burst, gate: Gate, now: u64, samples: usize) -> std::vec::Vec<f32> {
    match burst.envelope(gate, now, &tone(now), samples, 3.0) {
        Envelope::Flat(level) => std::vec![level; samples],
        Envelope::Edge(levels) => levels.to_vec(),
    }
}

fn run(burst: &mut Burst, gate: Gate, blocks: Range<u64>) -> std::vec::Vec<f32> {
    blocks.flat_map(|k| levels(burst, gate, 32 * k, 32)).collect()
}

#[test]
fn a_hard_burst_lasts_whole_periods_from_a_zero_crossing() {
    for (on, off) in [(3e-6, 200e-6), (14e-6, 200e-6), (100e-6, 101e-6), (32e-6, 640e-6), (77e-6, 640e-6)] {
        let got = run(&mut burst(window(on, off), Edge::Hard), Gate::Scheduled, 0..40);
        let first = got.iter().position(|&level| level == 1.0).unwrap();
        let last = got.iter().rposition(|&level| level == 1.0).unwrap() + 1;
        assert!(got[first..last].iter().all(|&level| level == 1.0));
        assert!(got[..first].iter().chain(&got[last..]).all(|&level| level == 0.0));
        assert_ne!(falling(tone(0).phase_at(first - 1)), falling(tone(0).phase_at(first)));
        assert!(first as f64 >= on * 1e6 && (first as f64) < on * 1e6 + 13.0, "{first} for {on}");
        assert!(last as f64 >= off * 1e6 && (last as f64) < off * 1e6 + 25.0, "{last} for {off}");
        let periods = (last - first) as f64 / (1e6 / 40_404.0);
        assert!((periods - libm::round(periods)).abs() < 1.0 / 24.0 && periods > 0.9, "{periods}");
    }
}

#[test]
fn a_gate_that_closes_before_a_zero_crossing_has_no_effect() {
    // The first zero crossing after the beginning is at sample 13.
    let got = run(&mut burst(window(2e-6, 9e-6), Edge::Hard), Gate::Scheduled, 0..4);
    assert!(got.iter().all(|&level| level == 0.0));
}

#[test]
fn blocks_join_continuously() {
    for edge in [Edge::Hard, Edge::Soft] {
        let mut whole = burst(window(13e-6, 90e-6), edge);
        let mut parts = whole.clone();
        let got: std::vec::Vec<f32> = (0..8).flat_map(|k| levels(&mut parts, Gate::Scheduled, 16 * k, 16)).collect();
        let expected: std::vec::Vec<f32> = (0..2).flat_map(|k| levels(&mut whole, Gate::Scheduled, 64 * k, 64)).collect();
        // A soft edge restarts its oscillator in each block. Measured: 1.4e-6, and zero at its ends
        // and for a hard edge.
        let same = |(got, expected): (&f32, &f32)| {
            got == expected || (edge != Edge::Hard && *got > 0.0 && *got < 1.0 && (got - expected).abs() < 2e-6)
        };
        assert!(got.iter().zip(&expected).all(same), "{got:?}");
    }
}

#[test]
fn soft_edge_is_a_raised_cosine() {
    let got = run(&mut burst(window(0.0, 1.0), Edge::Soft), Gate::Scheduled, 0..2);
    assert!((got[11] - 0.468_6).abs() < 1e-3, "{got:?}");
    assert!(got.windows(2).all(|pair| pair[1] >= pair[0]));
    assert_eq!(got[24], 1.0);
}

#[test]
fn periodic_schedule_repeats() {
    let mut periodic = burst(ScheduleConfig::Periodic { period_s: 1e-3, duty: 0.25 }, Edge::Hard);
    let ones = run(&mut periodic, Gate::Scheduled, 31_250..31_250 + 625).iter().filter(|&&level| level == 1.0).count();
    assert!((20 * 250 - 250..20 * 250 + 300).contains(&ones), "{ones}");
}

/// A resonance `y' = (drive - y) / tau` in envelope: the brake leaves nothing, at any headroom.
#[test]
fn a_brake_stops_the_residual_vibration() {
    for (q, headroom) in [(65.0, 1.0), (65.0, 5.16), (20.0, 1.5), (200.0, 2.0)] {
        let periods = q / core::f32::consts::PI;
        let brake = Brake::of(periods, headroom);
        assert!(brake.level <= headroom && brake.half_cycles.is_multiple_of(2), "{brake:?}");
        let t = brake.half_cycles as f32 / (2.0 * periods);
        let left = libm::expf(-t) * (1.0 + brake.level) - brake.level;
        assert!(left.abs() < 1e-5, "{left}");
    }
    let mut braked = burst(ScheduleConfig::Continuous, Edge::Hard);
    braked.set_brake(Some(Brake { half_cycles: 4, level: 0.7 }));
    run(&mut braked, Gate::On, 0..5);
    let got = run(&mut braked, Gate::Brake, 5..12);
    let against = got.iter().filter(|&&level| level == -0.7).count();
    assert!((49..=50).contains(&against), "{against} samples");
    let end = got.iter().rposition(|&level| level == -0.7).unwrap();
    assert!(got[end + 1..].iter().all(|&level| level == 0.0) && end < 80);
}

#[test]
fn windows_out_of_order_are_refused() {
    let windows = [(2.0, 3.0), (1.0, 1.5)].into_iter().collect();
    let config = Config { schedule: ScheduleConfig::Windows(windows), ..Config::default() };
    assert_eq!(Burst::build(&config, 40e3, 1e6).unwrap_err(), Error::BurstWindows);
}

fn configured(edge: Edge, brake: bool) -> Burst {
    Burst::build(&Config { schedule: ScheduleConfig::Continuous, edge, edge_cycles: 1.0, brake }, 40e3, 1e6).unwrap()
}

const BRAKE: Brake = Brake { half_cycles: 4, level: 0.7 };

#[test]
fn only_hard_bursts_begin_at_once() {
    assert_eq!([Edge::Hard, Edge::Soft, Edge::Boost].map(|edge| configured(edge, false).is_hard()), [true, false, false]);
}

#[test]
fn a_burst_ends_with_a_brake_by_order_or_by_configuration() {
    let gates = [Gate::Scheduled, Gate::On, Gate::Off, Gate::Brake];
    assert_eq!(gates.map(|gate| configured(Edge::Hard, false).brakes(gate)), [false, false, false, true]);
    assert_eq!(gates.map(|gate| configured(Edge::Hard, true).brakes(gate)), [true; 4]);
}

#[test]
fn a_brake_above_the_drive_is_reported() {
    let mut braked = configured(Edge::Hard, false);
    assert_eq!((braked.loudest(), braked.brake()), (1.0, None));
    for (level, loudest) in [(0.7, 1.0), (3.0, 3.0)] {
        let brake = Some(Brake { half_cycles: 4, level });
        braked.set_brake(brake);
        assert_eq!((braked.loudest(), braked.brake()), (loudest, brake));
        run(&mut braked, Gate::On, 0..5);
        let got = run(&mut braked, Gate::Brake, 5..12);
        let least = got.iter().copied().fold(0.0, f32::min);
        assert!((least + level).abs() < 1e-6, "{least}");
    }
    // With the transducer, its brake is discarded.
    braked.restart();
    assert_eq!((braked.loudest(), braked.brake(), braked.is_under_way(Gate::Brake)), (1.0, None, false));
}

#[test]
fn a_brake_that_has_begun_is_under_way_until_it_is_over() {
    let gates = [Gate::Scheduled, Gate::On, Gate::Off, Gate::Brake];
    let under_way = |burst: &Burst| gates.map(|gate| burst.is_under_way(gate));
    let mut plain = configured(Edge::Hard, false);
    run(&mut plain, Gate::On, 0..5);
    assert_eq!(under_way(&plain), [false; 4]);
    let mut braked = configured(Edge::Hard, false);
    braked.set_brake(Some(BRAKE));
    assert_eq!(under_way(&braked), [false; 4]);
    run(&mut braked, Gate::On, 0..5);
    assert_eq!(under_way(&braked), [false, false, false, true]);
    while !matches!(braked.state, State::Braking { .. }) {
        run(&mut braked, Gate::Brake, 5..6);
    }
    assert_eq!(under_way(&braked), [true; 4]);
    run(&mut braked, Gate::Brake, 6..12);
    assert_eq!(under_way(&braked), [false; 4]);
    // A boost is planned for its drive, up and down.
    let mut boosted = configured(Edge::Boost, false);
    boosted.state = State::Rising { falling: false, left: 2 };
    assert_eq!(under_way(&boosted), [true; 4]);
    boosted.state = State::Open { falling: false };
    assert_eq!(under_way(&boosted), [false, false, true, true]);
}

#[test]
fn each_gate_requests_the_drive_or_not() {
    let mut periodic = burst(ScheduleConfig::Periodic { period_s: 1e-3, duty: 0.25 }, Edge::Hard);
    let requested = [0, 249, 250, 999, 1000].map(|now| periodic.is_requested(Gate::Scheduled, now));
    assert_eq!(requested, [true, true, false, false, true]);
    assert_eq!([Gate::On, Gate::Off, Gate::Brake].map(|gate| periodic.is_requested(gate, 500)), [true, false, false]);
}

#[test]
fn the_length_of_a_soft_edge_is_limited() {
    // 2^20 samples are 1048 periods of 1 kHz.
    let build = |edge_cycles: f32| {
        let config = Config { schedule: ScheduleConfig::Continuous, edge: Edge::Soft, edge_cycles, brake: false };
        Burst::build(&config, 1e3, 1e6).map(drop)
    };
    assert_eq!((build(1048.0), build(1049.0).is_err()), (Ok(()), true));
}

#[test]
fn blocks_without_an_edge_are_flat_and_means_are_exact() {
    for edge in [Edge::Hard, Edge::Soft] {
        let mut bursts = burst(window(77e-6, 333e-6), edge);
        let mut edges = 0;
        for k in 0..20 {
            let expected = levels(&mut bursts.clone(), Gate::Scheduled, 32 * k, 32);
            let mean = expected.iter().sum::<f32>() / 32.0;
            let got = bursts.envelope(Gate::Scheduled, 32 * k, &tone(32 * k), 32, 3.0);
            assert!((got.mean() - mean).abs() < 1e-6, "{edge:?} {k}: {} {mean}", got.mean());
            let same = expected.iter().all(|level| *level == expected[0]);
            assert!(!got.is_flat() || same, "{edge:?} {k}");
            edges += usize::from(!got.is_flat());
        }
        // Two blocks in which the gate changes, plus the blocks in which the drive follows.
        assert!((2..=6).contains(&edges), "{edges}");
    }
}

#[test]
fn a_soft_edge_reverses_with_its_gate() {
    let config = Config { schedule: window(0.0, 50e-6), edge: Edge::Soft, edge_cycles: 4.0, brake: false };
    let got = run(&mut Burst::build(&config, 40e3, 1e6).unwrap(), Gate::Scheduled, 0..5);
    assert!((got[49] - 0.5).abs() < 1e-3, "{}", got[49]);
    for n in 0..49 {
        assert!((got[48 - n] - got[50 + n]).abs() < 1e-4, "{n}: {} {}", got[48 - n], got[50 + n]);
    }
    assert!(got[99..].iter().all(|&level| level == 0.0));
    let steepest = got.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
    assert!(steepest < 0.016, "{steepest}");
}

#[test]
fn a_brake_ends_a_soft_burst_from_its_full_level() {
    let mut braked = configured(Edge::Soft, false);
    braked.set_brake(Some(BRAKE));
    run(&mut braked, Gate::On, 0..5);
    let got = run(&mut braked, Gate::Brake, 5..12);
    let first = got.iter().position(|&level| level != 1.0).unwrap();
    let end = got.iter().rposition(|&level| level == -0.7).unwrap();
    assert!(first > 0 && (48..=49).contains(&(end - first)), "{first} {end}");
    assert!(got[first..=end].iter().all(|&level| level == -0.7) && got[end + 1..].iter().all(|&level| level == 0.0));
    // An incomplete edge returns along its ramp.
    let mut early = configured(Edge::Soft, false);
    early.set_brake(Some(BRAKE));
    assert!(levels(&mut early, Gate::On, 0, 16).iter().all(|&level| level < 0.8));
    assert!(levels(&mut early, Gate::Brake, 16, 32).iter().all(|&level| (0.0..0.8).contains(&level)));
}

#[test]
fn a_soft_burst_ordered_during_a_brake_begins_with_its_ramp() {
    let mut braked = configured(Edge::Soft, false);
    braked.set_brake(Some(BRAKE));
    run(&mut braked, Gate::On, 0..5);
    while !matches!(braked.state, State::Braking { .. }) {
        run(&mut braked, Gate::Brake, 5..6);
    }
    // In one block, the brake ends and the drive crosses zero again.
    let mut got = levels(&mut braked, Gate::On, 6 * 32, 96);
    got.extend(run(&mut braked, Gate::On, 9..12));
    let up = got.iter().position(|&level| level > 0.0).unwrap();
    assert!(got[up] < 0.1 && got[up..].windows(2).all(|pair| pair[1] - pair[0] < 0.1), "{:?}", &got[up..]);
    assert_eq!(got.last(), Some(&1.0));
}

#[test]
fn an_envelope_that_is_set_at_once_has_no_edge() {
    for edge in [Edge::Hard, Edge::Soft] {
        let mut now = configured(edge, false);
        assert_eq!(now.set_envelope_now(true, &tone(0), 32), Envelope::Flat(1.0));
        assert_eq!(levels(&mut now, Gate::On, 32, 32), [1.0; 32]);
        assert_eq!(now.set_envelope_now(false, &tone(64), 32), Envelope::Flat(0.0));
        assert_eq!(levels(&mut now, Gate::Off, 96, 32), [0.0; 32]);
    }
}

#[test]
fn the_shortest_brake_within_the_headroom_is_used() {
    for (periods, headroom) in [(20.7, 1.0), (20.7, 5.16), (3.0, 0.5), (60.0, 2.0)] {
        let brake = Brake::of(periods, headroom);
        let level = |half_cycles: u32| 1.0 / libm::expm1f(half_cycles as f32 / (2.0 * periods));
        assert!(level(brake.half_cycles) <= headroom && level(brake.half_cycles - 2) > headroom, "{brake:?}");
    }
    // At least one period; without headroom, a thousandth is assumed.
    assert_eq!(Brake::of(0.1, 10.0).half_cycles, 2);
    assert_eq!(Brake::of(20.0, 0.0), Brake::of(20.0, 1e-3));
}

#[test]
fn a_burst_of_a_chirp_ends_at_a_zero_crossing() {
    // From 20 to 60 kHz within a block of 96 samples.
    let chirp = Stretch { phase: 0, word: tuning_word(0.02), step: tuning_word(0.04 / 96.0) };
    for closes in 3..95 {
        let mut chirped = burst(window(1e-6, f64::from(closes) * 1e-6), Edge::Hard);
        let Envelope::Edge(levels) = chirped.envelope(Gate::Scheduled, 0, &chirp, 96, 3.0) else { panic!("an edge") };
        let got = levels.to_vec();
        let passes = |n: &usize| falling(chirp.phase_at(*n)) != falling(chirp.phase_at(n - 1));
        let edges: std::vec::Vec<usize> = (1..96).filter(|&n| got[n] != got[n - 1]).collect();
        assert!(edges.iter().all(passes) && edges.len() <= 2, "{closes}: {edges:?}");
        // The first zero crossing after the gate has opened, and the first one in the same
        // direction after it has closed.
        let crossings: std::vec::Vec<usize> = (1..96).filter(passes).collect();
        let expected = (crossings[0] < closes as usize).then(|| {
            let end = crossings.iter().step_by(2).find(|&&n| n >= closes as usize);
            [Some(crossings[0]), end.copied()].into_iter().flatten().collect::<std::vec::Vec<_>>()
        });
        assert_eq!(edges, expected.unwrap_or_default(), "{closes}");
    }
}
