//! Complete lane calibration: different amplifiers, a multiplexer, noise, and the resulting trims.

mod storage;

use firmware::board::command::{Command, Reply, TrimReport, Verb};
use firmware::board::stored_state::StoredState;
use firmware::generate::phasing::Phasing;
use firmware::seam::config::Direction;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::units::{Hertz, Turns};
use hal_mock::bench::{Bench, Queues, Setup};
use scene::load::load;
use sim::instruments::measure;
use sim::metrics::Metrics;
use sim::run::Watch;

use super::bank::{Bank, THESIS, tone_of};
use super::*;

/// Number of blocks that is sufficient for a calibration of four lanes.
const CALIBRATES_WITHIN: u64 = 60_000;
/// Largest phase error after a calibration, degrees.
const MAX_PHASE_ERROR_DEG: f64 = 0.1;
/// Largest relative gain error after a calibration.
const MAX_GAIN_ERROR: f64 = 1e-3;

fn four_lanes(direction: Direction) -> Setup {
    setup(|config| {
        config.lanes = 4;
        config.phasing.direction = direction;
        config.drive.scan_volts = 3.0;
        // The test waits for the calibration without sending, longer than a host may normally be
        // silent.
        config.link.patience_s = 0.0;
    })
}

fn bench_of<'a>(queues: &'a mut Queues, setup: &Setup, bank: Bank) -> Bench<'a, Bank> {
    Bench::new(queues, setup, bank).unwrap()
}

/// Orders a calibration, waits for its end, and returns its duration in blocks.
fn calibrated(bench: &mut Bench<Bank>) -> u64 {
    assert_eq!(bench.ask(Command::Calibrate), Some(Reply::Ack));
    bench.run_until(|report| report.mode == Mode::Calibrate, STARTS_WITHIN).expect("a calibration begins");
    let took = bench.run_until(|report| report.mode != Mode::Calibrate, CALIBRATES_WITHIN).expect("a calibration ends");
    bench.blocks(4);
    took
}

fn run(bench: &mut Bench<Bank>) {
    assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some(), "{:?}", bench.latest());
}

/// Returns the largest errors of running lanes over the window, also between the calibrated
/// frequencies: degrees, and relative gain.
fn errors(bench: &mut Bench<Bank>, quadrature: f32) -> (f64, f64) {
    let offsets = Phasing::offsets(quadrature).map(|offset| f64::from(offset) / 4_294_967_296.0);
    let mut worst = (0.0_f64, 0.0_f64);
    for step in -10..=10 {
        // Not exactly round numbers, so that rounding averages out here too.
        assert_eq!(bench.ask(Command::Detune(Hertz(2020.0 * step as f32 / 10.01))), Some(Reply::Ack));
        bench.blocks(610);
        let hz = f64::from(bench.latest().unwrap().frequency.0);
        let tones: Vec<(f64, f64)> = bench.analog().outputs.iter().map(|volts| tone_of(volts, hz)).collect();
        for (tone, offset) in tones.iter().zip(offsets) {
            let turns = (tone.1 - tones[0].1 - offset + 2.5).fract() - 0.5;
            worst = (worst.0.max(360.0 * turns.abs()), worst.1.max((tone.0 / tones[0].0 - 1.0).abs()));
        }
    }
    worst
}

fn report(bench: &mut Bench<Bank>, point: u8) -> TrimReport {
    match bench.ask(Command::Settings(Verb::Trims(point))) {
        Some(Reply::Settings(report)) => report,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_thesis_lanes_end_within_0_1_degree_and_0_1_percent() {
    for (direction, quadrature) in [(Direction::Forward, 0.25), (Direction::Reverse, -0.25)] {
        let mut queues = Queues::default();
        let mut bench = bench_of(&mut queues, &four_lanes(direction), Bank::new(THESIS, 1.0));
        run(&mut bench);
        let before = errors(&mut bench, quadrature);
        assert!(before.0 > 8.0 && before.1 > 0.06, "{before:?}");
        let took = calibrated(&mut bench);
        assert_eq!((bench.mode(), bench.fault()), (Mode::Idle, None));
        run(&mut bench);
        let after = errors(&mut bench, quadrature);
        println!(
            "{direction:?}: {:.2} degrees and {:.2} % before, {:.3} degrees and {:.3} % after {took} blocks",
            before.0,
            100.0 * before.1,
            after.0,
            100.0 * after.1
        );
        assert!(after.0 < MAX_PHASE_ERROR_DEG && after.1 < MAX_GAIN_ERROR, "{after:?}");
        // The trims are also valid for the other direction.
        assert_eq!(bench.ask(Command::Quadrature(Some(Turns(-quadrature)))), Some(Reply::Ack));
        let other = errors(&mut bench, -quadrature);
        assert!(other.0 < MAX_PHASE_ERROR_DEG && other.1 < MAX_GAIN_ERROR, "{other:?}");
    }
}

#[test]
fn a_missing_or_implausible_lane_is_a_fault() {
    let cases: [fn(&mut Bank); 4] = [
        |bank| bank.disconnected = Some(2),
        |bank| bank.amplifiers[1].gain = 0.6,
        |bank| bank.amplifiers[3].pole = 30e3,
        |bank| bank.amplifiers[2].gain = -1.0,
    ];
    for (n, change) in cases.into_iter().enumerate() {
        let mut queues = Queues::default();
        let mut bench = bench_of(&mut queues, &four_lanes(Direction::Forward), Bank::new(THESIS, 1.0));
        calibrated(&mut bench);
        let found = report(&mut bench, 2);
        change(bench.analog());
        calibrated(&mut bench);
        assert_eq!(
            (bench.mode(), bench.fault(), bench.fault().map(Fault::code)),
            (Mode::Fault, Some(Fault::LaneImplausible), Some(24)),
            "{n}"
        );
        assert!(!bench.analog().is_driven && !bench.enable.is_high(), "{n}");
        assert_eq!(report(&mut bench, 2), found, "{n}");
    }
    // The self-test measures lane 0.
    let mut queues = Queues::default();
    let mut bench = bench_of(&mut queues, &four_lanes(Direction::Forward), Bank::new(THESIS, 1.0));
    bench.analog().disconnected = Some(0);
    bench.ask(Command::Calibrate);
    bench.blocks(STARTS_WITHIN);
    assert_eq!(bench.fault(), Some(Fault::SensorImplausible));
}

#[test]
fn another_order_ends_a_calibration_and_keeps_the_trims() {
    let orders = [(Command::Idle, Mode::Idle), (Command::Run, Mode::Run), (Command::Scan, Mode::Scan)];
    for (order, mode) in orders {
        let mut queues = Queues::default();
        let mut bench = bench_of(&mut queues, &four_lanes(Direction::Forward), Bank::new(THESIS, 0.0));
        calibrated(&mut bench);
        let found = report(&mut bench, 2);
        bench.ask(Command::Calibrate);
        assert!(bench.run_until(|report| report.mode == Mode::Calibrate, STARTS_WITHIN).is_some());
        bench.blocks(3000);
        bench.ask(order);
        assert!(bench.run_until(|report| report.mode == mode, 2 * STARTS_WITHIN).is_some(), "{order:?} {:?}", bench.latest());
        bench.ask(Command::Idle);
        bench.blocks(STARTS_WITHIN);
        assert_eq!((report(&mut bench, 2), bench.analog().is_driven), (found, false), "{order:?}");
        run(&mut bench);
        let after = errors(&mut bench, 0.25);
        assert!(after.0 < MAX_PHASE_ERROR_DEG && after.1 < MAX_GAIN_ERROR, "{order:?} {after:?}");
    }
}

#[test]
fn an_emergency_stop_ends_a_calibration() {
    let mut queues = Queues::default();
    let mut bench = bench_of(&mut queues, &four_lanes(Direction::Forward), Bank::new(THESIS, 0.0));
    bench.ask(Command::Calibrate);
    assert!(bench.run_until(|report| report.mode == Mode::Calibrate, STARTS_WITHIN).is_some());
    bench.press_stop();
    bench.blocks(4);
    assert_eq!((bench.fault(), bench.enable.is_high(), bench.analog().is_driven), (Some(Fault::EmergencyStop), false, false));
    assert_eq!(report(&mut bench, 0).points, 0);
}

#[test]
fn a_calibration_runs_once_per_order() {
    let mut queues = Queues::default();
    let mut one = bench_of(&mut queues, &Setup::default(), Bank::new(THESIS, 0.0));
    assert_eq!(one.ask(Command::Calibrate), Some(Reply::Ack));
    assert!(one.run_until(|report| report.mode == Mode::Calibrate, STARTS_WITHIN).is_some());
    one.blocks(STARTS_WITHIN);
    assert_eq!((one.mode(), one.fault(), report(&mut one, 0).stored), (Mode::Idle, None, StoredState::Nothing));
    assert_eq!(one.power_off().operations(), 0);

    let mut queues = Queues::default();
    let mut four = bench_of(&mut queues, &four_lanes(Direction::Forward), Bank::new(THESIS, 0.0));
    calibrated(&mut four);
    for command in [Command::Detune(Hertz(10.0)), Command::TelemetryEvery(10), Command::Settings(Verb::Store)] {
        assert_eq!(four.ask(command), Some(Reply::Ack));
        four.blocks(STARTS_WITHIN);
        assert_eq!((four.mode(), four.analog().is_driven), (Mode::Idle, false), "{command:?}");
    }
    // Two copies are written; a record that is already stored is not written again.
    let words = four.power_off().words_written();
    assert!((2 * 20..2 * 40).contains(&words), "{words}");
}

#[test]
fn a_scene_with_a_calibration_calibrates_and_runs() {
    let sets = ["controller.phasing.calibrate=true".to_owned()];
    let scene = load("lock", &sets).expect("a valid scene").scene;
    let record = sim::run::run(&scene.driven().expect("a driven scene"), Watch::default()).unwrap();
    let mut modes: Vec<Mode> = record.rows.iter().map(|row| row.mode).collect();
    modes.dedup();
    let calibration = [Mode::SelfTest, Mode::Calibrate, Mode::Idle];
    assert_eq!(modes, [&calibration[..], &[Mode::SelfTest, Mode::Scan, Mode::Lock, Mode::Run]].concat());
}

/// Runs the motor with miscalibrated lanes and these changes, and returns its metrics.
fn motor(changes: &[&str]) -> Metrics {
    let later = ["duration_s=0.62", "controller.burst.on_s=[0.5]", "controller.burst.off_s=[0.6]"];
    let sets: Vec<String> = later.iter().chain(changes).map(|&set| set.to_owned()).collect();
    let scene = load("usm-miscalibrated", &sets).unwrap_or_else(|error| panic!("{error}")).scene;
    let scene = scene.driven().expect("a driven scene");
    let record = sim::run::run(&scene, Watch::default()).unwrap();
    assert_eq!((record.last.mode, record.last.fault), (Mode::Run, None), "{changes:?}");
    measure(&scene, &record)
}

#[test]
fn a_calibration_corrects_the_wave_of_the_motor() {
    for changes in [
        &[][..],
        &["rig.rotor.mu=0", "rig.rotor.torque_nm=0"],
        &["controller.phasing.direction=reverse", "rig.rotor.torque_nm=0"],
    ] {
        let [before, after] = ["controller.phasing.calibrate=false", "controller.phasing.calibrate=true"].map(|calibrate| {
            let metrics = motor(&[changes, &[calibrate]].concat());
            ["lane_phase_error_deg_max", "lane_gain_error_percent_max", "backward_wave_percent"]
                .map(|name| metrics.get(name).expect("a metric of the motor"))
        });
        println!("{changes:?}: degrees, %, and backward wave in %: {before:.3?} before, {after:.3?} after");
        assert!(before[0] > 9.9 && before[1] > 5.9 && before[2] > 4.0, "{before:?}");
        assert!(after[0] < MAX_PHASE_ERROR_DEG && after[1] < 100.0 * MAX_GAIN_ERROR, "{after:?}");
        // The largest backward wave of two lanes within these errors.
        assert!(after[2] < 0.2, "{after:?}");
    }
}
