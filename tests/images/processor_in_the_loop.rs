//! The controller as thumb code under QEMU compared with the controller in this process: the same
//! codes and the same telemetry, bit for bit. This tests arithmetic only; an emulator cannot test
//! timing.
//!
//! Skipped, with a message, if QEMU or the target's core library is not installed. In continuous
//! integration (`CI=true`) this is a failure, unless `SONOGLIDE_PIL_UNAVAILABLE` is set, which
//! means that the installation has failed.

mod interpreter;
#[cfg(target_os = "linux")]
mod link;
mod scenes;
mod scrambled;

use std::io::Write as _;
use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use firmware::seam::block::{Amplitude, DriveBlock, Gate, MAX_LANES, Orders, Request, SenseBlock};
use firmware::seam::config::{
    Around, Chirp, ChirpKind, Config, Edge, Schedule, ShapeKind, Sweep, Then, TrackingMode, Trim, TrimPoint,
};
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use firmware::seam::units::{Hertz, Turns};
use hal_mock::block_clock::BlockClock;
use pil::{self, PilError, Qemu};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use scene::Scene;
use scene::load::load;
use scene::settings;
use sim::processor::{Here, Processor};
use sim::run::{Watch, run, run_on};

use self::scrambled::Scrambled;

fn image() -> Option<PathBuf> {
    is_there("processor in the loop").then(|| pil::image().expect("the image builds"))
}

/// Returns `true` if a processor in the loop is possible. Prints a message otherwise.
pub fn is_there(what: &str) -> bool {
    is_possible(what, pil::missing())
}

/// Returns `true` if nothing is missing for a test. Prints a message otherwise.
pub fn is_possible(what: &str, missing: Option<String>) -> bool {
    let Some(reason) = missing else { return true };
    let in_ci = std::env::var("CI").is_ok_and(|ci| ci == "true");
    let excused = std::env::var_os("SONOGLIDE_PIL_UNAVAILABLE").is_some();
    assert!(!in_ci || excused, "no processor in the loop in continuous integration: {reason}");
    // Directly to the stream: output of a passing test by a macro is not shown.
    let loudly = "========================================================================";
    let banner = format!("{loudly}\nNOT TESTED: the thumb code of the controller; installing QEMU has failed\n{loudly}\n");
    let text = format!("\n{}SKIPPED, {what}: {reason}\n", if excused { &banner } else { "" });
    std::io::stderr().write_all(text.as_bytes()).expect("standard error");
    false
}

fn scene(name: &str) -> Scene {
    load(name, &[]).expect("a built-in scene").scene
}

/// Returns the configuration of the firmware in a built-in scene.
fn config(name: &str) -> Config {
    settings::config(&scene(name).driven().expect("a driven scene"))
}

/// Returns every bit of a report.
fn bits(telemetry: &Telemetry) -> Vec<u8> {
    postcard::to_slice(telemetry, &mut [0; 1024]).expect("telemetry can be encoded").to_vec()
}

#[test]
fn host_and_thumb_play_identical_codes() {
    let Some(image) = image() else { return };
    // Power-up, self-test, scan, lock, and two bursts, with the noise of the converters.
    let scene = scene("lock");
    let scene = scene.driven().expect("a driven scene");
    let here = run(&scene, Watch::default()).expect("a run on the host");
    let mut qemu = Qemu::start(&image, &settings::config(&scene)).expect("QEMU starts");
    let there = run_on(&mut qemu, &scene, Watch::default()).expect("a run on QEMU");

    assert_eq!(here.drive_hash, there.drive_hash, "hashes of all drive codes played");
    assert_eq!(bits(&here.last), bits(&there.last), "{:?}\n{:?}", here.last, there.last);
    let counted = there.instructions.expect("QEMU counts");
    assert_eq!(counted.blocks, 9375);
    // On average 2800, and 4553 in the worst block.
    assert!(counted.worst < 5440 && (2000..3500).contains(&(counted.total / counted.blocks)), "{counted:?}");
    let memory = there.memory.expect("the image measures its stack");
    println!("{counted:?} {memory:?}");
    assert!(memory.stack_blocks < memory.stack_power_up && memory.stack_blocks > 1000, "{memory:?}");
    // Identical silence would prove little.
    let driven = there.rows.iter().filter(|row| row.mode == Mode::Run && row.drive_v > 0.0).count();
    assert!(driven > 1000, "{driven} blocks driven in a burst, of {}", there.rows.len());
}

/// Compares both for any sense codes and any orders.
#[test]
fn host_and_thumb_answer_random_blocks_alike() {
    let Some(image) = image() else { return };
    for (number, config) in configs().iter().enumerate() {
        let mut here = Here::new(config).expect("a valid configuration");
        let mut there = Qemu::start(&image, config).expect("QEMU starts");
        assert_eq!(here.silence(), there.silence());
        let mut operator = Operator::new(number as u64);
        let mut clock = BlockClock::new(Scrambled::new(config, number as u64), &here.silence());
        let (mut modes, mut sounding) = (Vec::new(), 0);
        for block in 0..4000 {
            let orders = operator.orders(block);
            let (ours, theirs, drive) = clock.tick(|sense, drive| {
                let mut also = DriveBlock::default();
                let theirs = there.process(&orders, sense, &mut also).expect("QEMU runs");
                let ours = here.process(&orders, sense, drive).expect("this process runs");
                assert_eq!(*drive, also, "configuration {number}, block {block}: {ours:?}");
                (ours, theirs, also)
            });
            assert_eq!(bits(&ours), bits(&theirs), "configuration {number}, block {block}:\n{ours:?}\n{theirs:?}");
            sounding += usize::from(drive != there.silence());
            if !modes.contains(&ours.mode) {
                modes.push(ours.mode);
            }
        }
        for mode in [Mode::Idle, Mode::SelfTest, Mode::Fault] {
            assert!(modes.contains(&mode), "configuration {number} never reached {mode:?}: {modes:?}");
        }
        let beyond = if config.tracking.mode == TrackingMode::Off { Mode::Run } else { Mode::Scan };
        assert!(modes.contains(&beyond), "configuration {number} never reached {beyond:?}: {modes:?}");
        assert!(sounding > 400, "configuration {number} played only {sounding} blocks");
    }
}

#[test]
fn a_refused_configuration_comes_back_as_text() {
    let Some(image) = image() else { return };
    let mut config = config("experiment-1");
    config.tracking.nominal_q = -1.0;
    let expected = Here::new(&config).err().expect("a refusal").to_string();
    match Qemu::start(&image, &config).err().expect("a refusal") {
        PilError::Config(reason) => assert_eq!(reason, expected),
        other => panic!("{other}"),
    }
}

#[test]
fn a_lost_emulator_is_an_error() {
    let Some(image) = image() else { return };
    for (signal, expected) in [("-KILL", "signal: 9"), ("-STOP", "did not answer")] {
        let mut qemu = Qemu::start(&image, &config("experiment-1")).expect("QEMU starts");
        qemu.set_patience(Duration::from_millis(500));
        let killed = Command::new("kill").args([signal, &qemu.process_id().to_string()]).status().expect("kill runs");
        assert!(killed.success());
        let began = Instant::now();
        let mut ask = || qemu.process(&Orders::default(), &SenseBlock::default(), &mut DriveBlock::default());
        // QEMU may still answer until the signal has reached all its threads.
        let lost = loop {
            assert!(began.elapsed() < Duration::from_secs(20), "QEMU still runs after {:?}", began.elapsed());
            if let Err(lost) = ask() {
                break lost.to_string();
            }
        };
        assert!(lost.contains(expected), "{lost}");
        assert!(ask().is_err(), "later calls must fail too");
    }
}

/// Returns configurations that together cover every branch of the waveform: shapes, lanes, trims,
/// edges, schedules, trackers.
fn configs() -> [Config; 6] {
    let tracked = config("experiment-1");
    let mut held = tracked.clone();
    held.tracking.mode = TrackingMode::Off;
    held.lanes = 4;
    held.block_samples = 64;
    held.drive.shape = ShapeKind::Square;
    held.drive.amplitude = Amplitude::Volts(4.0);
    held.phasing.phase_trim_turns = [0.01, -0.02, 0.0, 0.25].into_iter().collect();
    held.phasing.gain_trim = [1.0, 0.93, 1.1, 0.5].into_iter().collect();
    held.burst.schedule = Schedule::Periodic { period_s: 7.3e-3, duty: 0.4 };
    (held.burst.edge, held.burst.edge_cycles) = (Edge::Soft, 9.5);
    held.front_end.metre_per_count = Some(1e-5);
    held.front_end.force_hz = Some(500.0);
    (held.limits.energy_j_per_m, held.limits.power_w, held.limits.on_time_s) = (Some(1e4), Some(2.0), Some(0.2));
    let mut zero_phase = tracked.clone();
    zero_phase.tracking.mode = TrackingMode::ZeroPhase;
    zero_phase.block_samples = 25;
    zero_phase.lanes = 2;
    let mut noise = held.clone();
    noise.drive.shape = ShapeKind::Noise;
    noise.drive.dither = true;
    let mut sawtooth = tracked.clone();
    sawtooth.lanes = 3;
    sawtooth.drive.shape = ShapeKind::Sawtooth;
    let chirp = Chirp {
        kind: ChirpKind::Linear,
        start_hz: -400.0,
        stop_hz: 600.0,
        time_s: 0.05,
        then: Then::UpDown,
        around: Around::Resonance,
    };
    sawtooth.sweep = Sweep::Chirp(chirp.clone());
    let mut chirping = held.clone();
    chirping.drive.shape = ShapeKind::Sine;
    chirping.phasing.calibration = [point(35e3, 0.01), point(45e3, -0.02)].into_iter().collect();
    let (kind, around) = (ChirpKind::Exponential, Around::Zero);
    chirping.sweep = Sweep::Chirp(Chirp { kind, start_hz: 20e3, stop_hz: 200e3, time_s: 0.03, then: Then::Repeat, around });
    [tracked, held, zero_phase, noise, sawtooth, chirping]
}

fn point(hz: f32, phase_turns: f32) -> TrimPoint {
    TrimPoint { hz, lanes: [Trim { phase_turns, gain: 1.0 - phase_turns }; MAX_LANES] }
}

/// Source of random orders.
struct Operator {
    random: Xoshiro256PlusPlus,
    orders: Orders,
}

impl Operator {
    fn new(seed: u64) -> Self {
        Operator { random: Xoshiro256PlusPlus::seed_from_u64(seed), orders: Orders::default() }
    }

    /// Returns the orders of a block. They sometimes change, mostly to a run.
    fn orders(&mut self, block: u32) -> Orders {
        if block == 40 || one_in(&mut self.random, 150) {
            let random = &mut self.random;
            self.orders = Orders {
                attempt: block,
                sequence: self.orders.sequence.wrapping_add(1),
                request: *pick(random, &[Request::Run, Request::Run, Request::Run, Request::Scan, Request::Idle]),
                gate: *pick(random, &[Gate::Scheduled, Gate::On, Gate::On, Gate::Off, Gate::Brake]),
                amplitude: *pick(random, &AMPLITUDES),
                detune: Hertz(*pick(random, &[0.0, 0.0, 123.4, -3e5, f32::NAN])),
                quadrature: *pick(random, &[None, None, Some(Turns(0.1)), Some(Turns(-7.0))]),
                friction: None,
                torso_kg: None,
                emergency_stop: one_in(random, 20),
                host_lost: false,
                clear_fault: !one_in(random, 4),
            };
        }
        self.orders
    }
}

/// Plausible amplitudes, and amplitudes that must be clamped.
const AMPLITUDES: [Option<Amplitude>; 8] = [
    None,
    Some(Amplitude::Volts(0.0)),
    Some(Amplitude::Volts(3.3)),
    Some(Amplitude::Volts(1e30)),
    Some(Amplitude::Volts(-1.0)),
    Some(Amplitude::MotionalCurrent(0.5)),
    Some(Amplitude::MotionalCurrent(1e-30)),
    Some(Amplitude::MotionalCurrent(f32::MAX)),
];

fn one_in(random: &mut Xoshiro256PlusPlus, count: u32) -> bool {
    random.next_u32().is_multiple_of(count)
}

fn pick<'a, T>(random: &mut Xoshiro256PlusPlus, choices: &'a [T]) -> &'a T {
    &choices[random.next_u32() as usize % choices.len()]
}
