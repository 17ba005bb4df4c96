use super::*;
use crate::generate::nco::tuning_word;
use crate::seam::config::Schedule as ScheduleConfig;

/// A soft edge takes a period.
fn burst(schedule: ScheduleConfig, edge: Edge) -> Burst {
    Burst::build(&Config { schedule, edge, edge_cycles: 1.0, brake: false }, 40e3, 1e6).unwrap()
}

fn window(on_s: f64, off_s: f64) -> ScheduleConfig {
    ScheduleConfig::Windows([(on_s, off_s)].into_iter().collect())
}

/// A tone whose period is 24.75 samples, from phase zero at sample zero.
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
fn a_hard_burst_lasts_whole_periods_from_a_passage_through_zero() {
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
fn a_gate_that_closes_before_zero_is_passed_opens_nothing() {
    // The first passage after the beginning is at sample 13.
    let got = run(&mut burst(window(2e-6, 9e-6), Edge::Hard), Gate::Scheduled, 0..4);
    assert!(got.iter().all(|&level| level == 0.0));
}

#[test]
fn blocks_join_without_a_seam() {
    for edge in [Edge::Hard, Edge::Soft] {
        let mut whole = burst(window(13e-6, 90e-6), edge);
        let mut parts = whole.clone();
        let got: std::vec::Vec<f32> = (0..8).flat_map(|k| levels(&mut parts, Gate::Scheduled, 16 * k, 16)).collect();
        let expected: std::vec::Vec<f32> = (0..2).flat_map(|k| levels(&mut whole, Gate::Scheduled, 64 * k, 64)).collect();
        // The oscillator of a soft edge is set again in each block. Measured: 1.4e-6, and nothing at its ends, nor of a hard one.
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

/// A resonance `y' = (drive - y) / tau` in envelope: after the brake nothing is left, whatever the headroom.
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
