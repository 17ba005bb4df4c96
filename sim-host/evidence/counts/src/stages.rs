//! Stages of the controller, called by their public functions.

use core::hint::black_box;

use firmware::generate::burst::envelope::{Envelope, Levels};
use firmware::generate::nco::{Stretch, tuning_word};
use firmware::generate::phasing::Phasing;
use firmware::generate::shape::Shape;
use firmware::generate::shape::sine;
use firmware::generate::shaper::{Play, Shaper};
use firmware::guard::{Driven, Guard, Stage};
use firmware::seam::block::{BeltSense, DriveBlock, SenseBlock};
use firmware::seam::config::{Config, Drive, Limits, ShapeKind, TrackingMode};
use firmware::seam::fault::Fault;
use firmware::seam::phasor::Phasor;
use firmware::seam::transducer;
use firmware::sense::belt::Belt;
use firmware::sense::convert::Convert;
use firmware::sense::demod::{Sensed, Suspect, demodulate};
use firmware::sense::motional::Motional;
use firmware::track::tracker::observer::{Observer, Played, Prior};
use firmware::track::tracker::{PlayedBlock, State, Tracker};
use qemu_m4::bench::{SAMPLES, Transducer, config};
use qemu_m4::counter::Counter;

use crate::csv::line;
use crate::repeat::repeat;

const REPETITIONS: u32 = 500;
/// Length of a block, s.
const BLOCK_S: f32 = 32e-6;

/// Amplitude of the voltage measured at the resonance of [`STACK`], V.
const VOLTS: f32 = 3.0;
/// Phasor of the motional current at the resonance, A: `V / Rm`.
const CURRENT: Phasor = Phasor::new(VOLTS / STACK.rm_ohm, 0.01);
/// Phasors of voltage and total current at the resonance, V and A.
const AT_RESONANCE: Sensed = Sensed { v: Phasor::new(VOLTS, 0.0), i: Phasor::new(1.0, 0.228) };
/// Noise of a block's current, A rms.
const NOISE_A: f32 = 5e-4;
const NOMINAL_HZ: f32 = 40e3;
const PLAYED: PlayedBlock = PlayedBlock {
    offset_hz: STACK.series_resonance_hz - NOMINAL_HZ,
    volts: VOLTS,
    envelope: Some(1.0),
    pure: true,
    on: true,
    driven: true,
    rung_up: false,
};
/// Number of blocks after which every tracker has locked.
const SETTLING_BLOCKS: u32 = 200;

/// Counts every stage, net of an empty loop.
pub fn count(counter: &Counter) {
    let empty = repeat(counter, REPETITIONS, || ());
    let print = |samples: usize, kernel: &str, work: &mut dyn FnMut()| {
        line("stage", kernel, samples, REPETITIONS, repeat(counter, REPETITIONS, work) - empty);
    };
    let print_long = |kernel: &str, work: &mut dyn FnMut()| print(2 * SAMPLES, kernel, work);
    let print = |kernel: &str, work: &mut dyn FnMut()| print(SAMPLES, kernel, work);
    listening(&print);
    tracking(&print, TrackingMode::PhaseLock, BLOCK_S, "tracker, phase loop");
    tracking(&print, TrackingMode::Observer, BLOCK_S, "tracker, observer");
    tracking(&print_long, TrackingMode::Observer, 2.0 * BLOCK_S, "tracker, observer, 64 samples a block");
    observing(&print);
    shapes(&print);
}

/// Function that prints the count of a stage, from its name and its code.
type Print<'a> = &'a dyn Fn(&str, &mut dyn FnMut());

/// Counts the stages that evaluate the sense codes and the phasors measured from them.
fn listening(print: Print) {
    let config = config(TrackingMode::PhaseLock, 4, SAMPLES);
    let convert = convert(&config);
    let sense = sense();
    let tone = Stretch { phase: 1 << 60, word: tuning_word(40_400.0 / 1e6), step: 0 };
    print("lock-in", &mut || {
        black_box(demodulate(black_box(&convert), black_box(&sense), black_box(&tone)));
    });
    let sensed = Sensed { v: Phasor::new(3.0, 0.0), i: Phasor::new(1.0, 0.15) };
    let mut guard = Guard::build(&config, BLOCK_S).expect("valid limits");
    let driven = Driven { volts: Some(3.0), stage: Stage::Following, requested: true, full: true, asked: 3.0 };
    let belt = Belt::build(&config, BLOCK_S);
    print("guard", &mut || {
        black_box(inspect(&mut guard, black_box(&convert), black_box(&sense), black_box(&sensed), black_box(&belt), &driven));
    });
    watching_a_belt(print, config, &convert, &sense, &sensed, &driven);
}

/// Counts the guard with an encoder, a force channel and every limit, over a moving belt; and the
/// belt.
fn watching_a_belt(print: Print, mut config: Config, convert: &Convert, sense: &SenseBlock, sensed: &Sensed, driven: &Driven) {
    (config.front_end.metre_per_count, config.front_end.force_hz) = (Some(1e-5), Some(500.0));
    config.limits = Limits { power_w: Some(9.0), energy_j_per_m: Some(1e3), on_time_s: Some(1e4), ..config.limits };
    let mut guard = Guard::build(&config, BLOCK_S).expect("valid limits");
    let mut belt = Belt::build(&config, BLOCK_S);
    let mut sense = sense.clone();
    let mut counts = 0;
    print("belt", &mut || {
        counts += 1;
        belt.update(black_box(Some(BeltSense { counts, broken: false })));
    });
    print("guard over a belt", &mut || {
        sense.slow.force = black_box(Some(sense.slow.force.unwrap_or(1.0) * 1.000_001));
        black_box(inspect(&mut guard, black_box(convert), black_box(&sense), black_box(sensed), black_box(&belt), driven));
    });
}

/// Runs everything that the guard does with a block.
fn inspect(
    guard: &mut Guard,
    convert: &Convert,
    sense: &SenseBlock,
    sensed: &Sensed,
    belt: &Belt,
    driven: &Driven,
) -> Option<Fault> {
    let electrical = guard.inspect(convert, sense, sensed, black_box(driven.volts), black_box(Suspect::default()));
    if guard.watches(sense, belt) {
        electrical.or(guard.watch(convert, sense, sensed, belt, black_box(driven)))
    } else {
        electrical
    }
}

/// Counts the tracker, locked and under full drive.
fn tracking(print: Print, mode: TrackingMode, block_s: f32, name: &str) {
    let branch = Motional::of_capacitance(STACK.c0_f, STACK.series_resonance_hz);
    let mut tracker = Tracker::build(&config(mode, 4, SAMPLES), block_s).expect("valid tracking");
    tracker.seed(&STACK, branch, NOISE_A, false);
    let follow = |tracker: &mut Tracker| {
        let (sensed, current, played) = black_box(&(AT_RESONANCE, CURRENT, PLAYED));
        black_box(tracker.follow(sensed, *current, *current, played));
    };
    (0..SETTLING_BLOCKS).for_each(|_| follow(&mut tracker));
    assert!(tracker.state() == State::Locked, "{:?}", tracker.state());
    print(name, &mut || follow(&mut tracker));
}

/// Counts the observer alone: a block that it follows, and one in which its drive changes.
fn observing(print: Print) {
    let mut observer = Observer::new(NOMINAL_HZ, BLOCK_S, 0.05 * NOMINAL_HZ);
    let offset_hz = STACK.series_resonance_hz - NOMINAL_HZ;
    let spread_hz = 60.0;
    let (q, axis) = (STACK.q, Phasor::new(1.0, 0.0));
    let lm_h = (STACK.lm_h, 2e-3 * STACK.lm_h);
    observer.start(&Prior { offset_hz: (offset_hz, spread_hz), q, lm_h, axis, noise_a: NOISE_A });
    let follow = |observer: &mut Observer, steady_v: Option<f32>| {
        let inputs = (CURRENT, AT_RESONANCE.v, Played { offset_hz, steady_v });
        let (current, voltage, played) = black_box(&inputs);
        observer.follow(*current, *voltage, *played);
    };
    (0..SETTLING_BLOCKS).for_each(|_| follow(&mut observer, Some(VOLTS)));
    print("observer alone", &mut || follow(&mut observer, Some(VOLTS)));
    print("observer alone, at an edge", &mut || follow(&mut observer, None));
}

/// Counts the shaper for every shape.
fn shapes(print: Print) {
    let held = Stretch { phase: 1 << 60, word: tuning_word(40_400.0 / 1e6), step: 0 };
    let chirp = Stretch { step: 1 << 40, ..held };
    let levels = [1 << 30; SAMPLES];
    let (flat, edge) = (Envelope::Flat(1.0), Envelope::Edge(Levels { parts: &levels, loudest: 1.0, mean: 0.5 }));
    use ShapeKind::{Noise, Sawtooth, Sine, Square};
    for (name, shape, dither, lanes, stretch, envelope) in [
        ("sine, one lane", Sine, false, 1, held, flat),
        ("sine, two lanes", Sine, false, 2, held, flat),
        ("sine, four lanes", Sine, false, 4, held, flat),
        ("sine, one lane, at an edge", Sine, false, 1, held, edge),
        ("sine, four lanes, at an edge", Sine, false, 4, held, edge),
        ("sine, one lane, chirp", Sine, false, 1, chirp, flat),
        ("sine, four lanes, chirp", Sine, false, 4, chirp, flat),
        ("sine, one lane, dither", Sine, true, 1, held, flat),
        ("square, one lane", Square, false, 1, held, flat),
        ("square, four lanes", Square, false, 4, held, flat),
        ("sawtooth, one lane", Sawtooth, false, 1, held, flat),
        ("sawtooth, four lanes", Sawtooth, false, 4, held, flat),
        ("noise, one lane", Noise, false, 1, held, flat),
        ("noise, four lanes", Noise, false, 4, held, flat),
        ("silence, one lane", Sine, false, 1, held, Envelope::Flat(0.0)),
        ("silence, four lanes", Sine, false, 4, held, Envelope::Flat(0.0)),
    ] {
        let config = config(TrackingMode::PhaseLock, lanes, SAMPLES);
        let config = Config { drive: Drive { shape, dither, ..config.drive.clone() }, ..config };
        let convert = convert(&config);
        let mut phasing = Phasing::build(&config).expect("lanes");
        let lanes = phasing.lanes(40_400.0, 0.25);
        let mut shape = Shape::build(&config).expect("a shape");
        let (mut shaper, mut drive) = (Shaper::build(&config), DriveBlock::default());
        print(name, &mut || {
            let (scale, stretch, samples, volts, envelope) =
                (&convert.drive, black_box(stretch), black_box(SAMPLES), black_box(3.0), black_box(envelope));
            shaper.shape(&mut shape, &Play { scale, lanes, stretch, samples, volts, louder: 1.0, envelope }, &mut drive);
            black_box(&drive);
        });
    }
}

fn convert(config: &Config) -> Convert {
    let mut convert = Convert::build(&config.front_end).expect("a valid front end");
    convert.i.set_limit(config.limits.current_a);
    convert
}

/// Returns a sense block at a drive of about 3 V.
fn sense() -> SenseBlock {
    let mut drive = DriveBlock::silent(1, SAMPLES, 0);
    let wave = |n: usize| (2048.0 + 300.0 * sine::rotation((n as u64) << 59).im) as u16;
    drive.lanes[0] = (0..SAMPLES).map(wave).collect();
    let mut sense = SenseBlock::default();
    Transducer::new().exchange(&drive, &mut sense);
    sense
}

/// A stack as identification reports it.
const STACK: transducer::Transducer = transducer::Transducer {
    series_resonance_hz: 40_400.0,
    parallel_resonance_hz: 41_300.0,
    q: 65.0,
    rm_ohm: 3.0,
    lm_h: 0.79e-3,
    cm_f: 20e-9,
    c0_f: 300e-9,
    coupling: 0.25,
    deviations: transducer::Deviations {
        series_resonance_hz: 0.0,
        parallel_resonance_hz: 0.0,
        q: 0.0,
        rm_ohm: 0.0,
        lm_h: 0.0,
        cm_f: 0.0,
        c0_f: 0.0,
        coupling: 0.0,
    },
    quality: transducer::LockQuality { loss: 0.0, others: 0.0, misfit: 0.0 },
    modes: 1,
    chosen: 0,
};
