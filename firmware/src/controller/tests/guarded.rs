//! Tests of the fault that a controller reports if a channel, a load or a belt fails.

use super::*;
use crate::seam::block::{BeltSense, Codes};
use crate::seam::config::{Around, Chirp, ChirpKind, Edge, Schedule, ShapeKind, Sweep, Then};
use crate::seam::fault::Fault;

/// A controller with its load, and the encoder counts of its belt, if there is one.
struct Bench {
    controller: Controller,
    queue: [DriveBlock; 2],
    load: Resonator,
    blocks: usize,
    counts: Option<i32>,
}

fn orders(gate: Gate) -> Orders {
    Orders { sequence: 1, attempt: 1, request: Request::Run, gate, ..Orders::default() }
}

impl Bench {
    fn new(change: impl FnOnce(&mut Config)) -> Self {
        let mut config = config();
        change(&mut config);
        let controller = Controller::build(&config).unwrap();
        let queue = [controller.silence(), controller.silence()];
        Bench { controller, queue, load: Resonator::default(), blocks: 0, counts: None }
    }

    /// Runs one block, whose codes pass through `tamper`.
    fn block(&mut self, gate: Gate, tamper: impl FnOnce(&mut SenseBlock)) -> Telemetry {
        let slot = self.blocks % 2;
        let mut sense = self.load.exchange(&self.queue[slot]);
        sense.slow.belt = self.counts.map(|counts| BeltSense { counts, broken: false });
        tamper(&mut sense);
        self.blocks += 1;
        self.controller.process(&orders(gate), &sense, &mut self.queue[slot])
    }

    /// Runs until 400 blocks of `Run` are over; the belt moves.
    fn run(mut self, gate: Gate) -> Self {
        let mut more = 400;
        while more > 0 {
            assert!(self.blocks < 10_000, "no `Run` within 10 000 blocks");
            self.counts.iter_mut().for_each(|counts| *counts += 1);
            let report = self.block(gate, |_| {});
            assert_eq!(report.fault, None, "block {}", self.blocks);
            more -= u32::from(report.mode == Mode::Run);
        }
        self
    }

    /// Returns the first fault within `blocks`, and the number of blocks until it.
    fn found(&mut self, blocks: usize, gate: Gate, tamper: impl Fn(&mut SenseBlock)) -> Option<(usize, Fault)> {
        (1..=blocks).find_map(|n| Some((n, self.block(gate, &tamper).fault?)))
    }

    /// Returns the fault that ends the self-test.
    fn tested(tamper: impl Fn(&mut SenseBlock)) -> Option<Fault> {
        Bench::new(|_| {}).found(300, Gate::On, tamper).map(|(_, fault)| fault)
    }
}

/// Changes the gain of a channel.
fn amplify(codes: &mut Codes, gain: f64) {
    codes.iter_mut().for_each(|code| *code = (4096.0 + gain * (f64::from(*code) - 4096.0)).clamp(0.0, 8190.0) as u16);
}

#[test]
fn over_current_is_a_short_in_the_self_test_only() {
    // The tone draws 32 mA. 3.2 A exceed the limit; only a short takes 0.3 A.
    assert_eq!(Bench::tested(|sense| amplify(&mut sense.i, 120.0)), Some(Fault::LoadShorted));
    let mut runs = Bench::new(|_| {}).run(Gate::On);
    assert_eq!(runs.found(3, Gate::On, |sense| amplify(&mut sense.i, 4.0)), Some((1, Fault::OverCurrent)));
}

#[test]
fn a_collapsed_voltage_with_a_high_current_is_a_short() {
    let collapses = |gain: f64| {
        Bench::tested(|sense| {
            amplify(&mut sense.v, 0.02);
            amplify(&mut sense.i, gain);
        })
    };
    assert_eq!((collapses(10.0), collapses(1.0)), (Some(Fault::LoadShorted), Some(Fault::SensorImplausible)));
    let mut runs = Bench::new(|_| {}).run(Gate::On);
    let found = runs.found(20, Gate::On, |sense| {
        amplify(&mut sense.v, 0.02);
        amplify(&mut sense.i, 2.5);
    });
    assert!(found.is_some_and(|(blocks, fault)| blocks <= 12 && fault == Fault::SensorImplausible), "{found:?}");
}

#[test]
fn a_gain_change_in_a_run_is_detected_within_12_blocks() {
    let changes: [fn(&mut SenseBlock); 4] = [
        |sense| amplify(&mut sense.i, 0.7),
        |sense| amplify(&mut sense.i, -1.0),
        |sense| amplify(&mut sense.v, 0.8),
        |sense| amplify(&mut sense.v, 1.18),
    ];
    for (n, change) in changes.into_iter().enumerate() {
        let mut runs = Bench::new(|_| {}).run(Gate::On);
        let found = runs.found(100, Gate::On, change);
        assert!(found.is_some_and(|(blocks, fault)| blocks <= 12 && fault == Fault::SensorImplausible), "{n}: {found:?}");
    }
}

#[test]
fn without_tracking_a_changed_voltage_is_detected() {
    let off = |config: &mut Config| config.tracking.mode = crate::seam::config::TrackingMode::Off;
    let mut runs = Bench::new(off).run(Gate::On);
    let found = runs.found(100, Gate::On, |sense| amplify(&mut sense.v, 0.8));
    assert!(found.is_some_and(|(blocks, fault)| blocks <= 12 && fault == Fault::SensorImplausible), "{found:?}");
    // Without tracking a jump of the current is not judged.
    let mut runs = Bench::new(off).run(Gate::On);
    assert_eq!(runs.found(400, Gate::On, |sense| amplify(&mut sense.i, 0.7)), None);
}

#[test]
fn a_failure_between_bursts_is_detected_in_the_next_one() {
    let bursts = |config: &mut Config| config.burst.schedule = Schedule::Periodic { period_s: 0.01, duty: 0.5 };
    let mut runs = Bench::new(bursts).run(Gate::Scheduled);
    assert_eq!(runs.found(2000, Gate::Scheduled, |_| {}), None);
    // Until the pause begins.
    while runs.block(Gate::Scheduled, |_| {}).envelope > 0.0 {}
    (0..20).for_each(|_| assert_eq!(runs.block(Gate::Scheduled, |_| {}).fault, None));
    let mut driven = 0;
    let found = (0..400).find_map(|_| {
        let report = runs.block(Gate::Scheduled, |sense| amplify(&mut sense.i, -1.0));
        driven += usize::from(report.envelope > 0.0);
        report.fault
    });
    assert!(found == Some(Fault::SensorImplausible) && driven <= 5, "{found:?} after {driven}");
}

#[test]
fn bursts_of_any_edge_raise_no_fault() {
    for edge in [Edge::Hard, Edge::Soft, Edge::Boost] {
        let mut runs = Bench::new(|config| {
            config.burst.schedule = Schedule::Periodic { period_s: 0.01, duty: 0.5 };
            config.burst.edge = edge;
        })
        .run(Gate::Scheduled);
        assert_eq!(runs.found(3000, Gate::Scheduled, |_| {}), None, "{edge:?}");
    }
}

#[test]
fn on_time_and_board_temperature_end_a_run() {
    let mut runs = Bench::new(|config| config.limits.on_time_s = Some(0.5)).run(Gate::On);
    let (blocks, fault) = runs.found(20_000, Gate::On, |_| {}).unwrap();
    assert!(fault == Fault::OnTimeExceeded && runs.blocks > 15_625, "{blocks} {fault:?}");
    let mut runs = Bench::new(|_| {}).run(Gate::On);
    assert_eq!(runs.found(9, Gate::On, |sense| sense.slow.temperature = Some(101.0)), Some((1, Fault::OverTemperature)));
}

#[test]
fn a_stopped_belt_is_a_fault_after_100_ms_of_requested_drive() {
    let belt = |config: &mut Config| config.front_end.metre_per_count = Some(1e-5);
    let moves = || Bench { counts: Some(0), ..Bench::new(belt) };
    let mut runs = moves().run(Gate::On);
    let (blocks, fault) = runs.found(5000, Gate::On, |_| {}).unwrap();
    assert!(fault == Fault::BeltStopped && (3190..3210).contains(&blocks), "{blocks} {fault:?}");
    // A drive that is not requested waits without a limit.
    let mut waits = moves().run(Gate::Off);
    assert_eq!(waits.found(10_000, Gate::Off, |_| {}), None);
}

#[test]
fn the_self_test_expects_the_trimmed_voltage() {
    let mut runs = Bench::new(|config| config.phasing.gain_trim = [0.6].into_iter().collect());
    let mode = (0..300).map(|_| runs.block(Gate::On, |_| {})).find(|report| !matches!(report.mode, Mode::Idle | Mode::SelfTest));
    assert_eq!(mode.map(|report| (report.mode, report.fault)), Some((Mode::Scan, None)));
}

/// Adds half the sample clock, which no tone explains, to the first `samples` of a block.
fn disturb(codes: &mut Codes, volts: f64, samples: usize) {
    let codes = codes.iter_mut().enumerate().take(samples);
    codes.for_each(|(n, code)| *code = (f64::from(*code) + volts / 0.005 * if n % 2 == 0 { 1.0 } else { -1.0 }) as u16);
}

#[test]
fn hum_in_silence_must_stay_within_the_voltage_limit() {
    let found = |volts: f64, samples: usize| {
        let mut runs = Bench::new(|config| config.limits.voltage_v = 12.0).run(Gate::On);
        assert_eq!(runs.found(100, Gate::Off, |_| {}), None);
        runs.found(100, Gate::Off, |sense| disturb(&mut sense.v, volts, samples))
    };
    assert_eq!((found(13.0, 32), found(15.0, 1), found(15.0, 32)), (None, None, Some((8, Fault::SensorImplausible))));
}

#[test]
fn a_distorted_measuring_tone_ends_the_scan() {
    for (volts, ends) in [(0.2, false), (1.0, true)] {
        let mut scans = Bench::new(|_| {});
        while scans.block(Gate::On, |_| {}).mode != Mode::Scan {}
        let found = scans.found(100, Gate::On, |sense| disturb(&mut sense.v, volts, 32));
        assert_eq!(
            found.filter(|found| found.0 <= 10).map(|found| found.1),
            ends.then_some(Fault::SensorImplausible),
            "{volts} V"
        );
    }
}

/// If the waveform is not a sine or the frequency moves, blocks are not compared: a voltage within
/// the range of the plain check is accepted.
#[test]
fn blocks_without_a_steady_tone_are_not_compared() {
    let square = |config: &mut Config| config.drive.shape = ShapeKind::Square;
    let chirp = |config: &mut Config| {
        let (kind, then, around) = (ChirpKind::Linear, Then::UpDown, Around::Resonance);
        config.sweep = Sweep::Chirp(Chirp { kind, start_hz: -50.0, stop_hz: 50.0, time_s: 0.01, then, around });
    };
    let found = |change: fn(&mut Config)| {
        let mut runs = Bench::new(change).run(Gate::On);
        runs.found(200, Gate::On, |sense| amplify(&mut sense.v, 0.8))
    };
    assert_eq!((found(square), found(chirp)), (None, None));
    assert!(found(|_| {}).is_some());
}
