//! Stages of the controller, by their public functions.

use core::hint::black_box;

use firmware::block::{DriveBlock, SenseBlock};
use firmware::burst::Envelope;
use firmware::config::{Config, Drive, ShapeKind};
use firmware::convert::Convert;
use firmware::demod::{Sensed, Suspect, demodulate};
use firmware::guard::{Driven, Guard};
use firmware::identify;
use firmware::motional::Motional;
use firmware::nco::{Stretch, tuning_word};
use firmware::phasing::Phasing;
use firmware::phasor::Phasor;
use firmware::shape::Shape;
use firmware::shape::sine;
use firmware::shaper::{Play, Shaper};
use firmware::tracker::{Heard, Tracker};

use crate::bench::{SAMPLES, Transducer, config};
use crate::counter::Counter;
use crate::csv::line;
use crate::repeat::repeat;

const REPETITIONS: u32 = 500;
/// Length of a block, s.
const BLOCK_S: f32 = 32e-6;

/// Counts every stage, net of a loop that does nothing.
pub fn count(counter: &Counter) {
    let empty = repeat(counter, REPETITIONS, || ());
    let print = |kernel: &str, work: &mut dyn FnMut()| {
        line("stage", kernel, SAMPLES, REPETITIONS, repeat(counter, REPETITIONS, work) - empty);
    };
    listening(&print);
    shapes(&print);
}

/// A stage's name, and the stage.
type Print<'a> = &'a dyn Fn(&str, &mut dyn FnMut());

/// What looks at the sense codes and at what is heard in them.
fn listening(print: Print) {
    let config = config(4, SAMPLES);
    let convert = convert(&config);
    let sense = sense();
    let tone = Stretch { phase: 1 << 60, word: tuning_word(40_400.0 / 1e6), step: 0 };
    print("lock-in", &mut || {
        black_box(demodulate(black_box(&convert), black_box(&sense), black_box(&tone)));
    });
    let sensed = Sensed { v: Phasor::new(3.0, 0.0), i: Phasor::new(1.0, 0.15) };
    let mut guard = Guard::build(&config, BLOCK_S).expect("valid limits");
    let driven = Driven { volts: Some(3.0), suspect: Suspect::default() };
    print("guard", &mut || {
        black_box(guard.inspect(black_box(&convert), black_box(&sense), black_box(&sensed), black_box(driven)));
    });
    let mut tracker = Tracker::build(&config, BLOCK_S).expect("valid tracking");
    tracker.seed(&STACK, Motional::of_capacitance(STACK.c0_f, STACK.series_resonance_hz));
    let heard = Heard { volts: 3.0, on: true, driven: true };
    let current = Phasor::new(1.0, 0.01);
    print("tracker", &mut || {
        black_box(tracker.follow(black_box(&sensed), black_box(current), black_box(&heard)));
    });
}

/// The shaper, for every shape.
fn shapes(print: Print) {
    let held = Stretch { phase: 1 << 60, word: tuning_word(40_400.0 / 1e6), step: 0 };
    let chirp = Stretch { step: 1 << 40, ..held };
    let levels = [0.5; SAMPLES];
    let (flat, edge) = (Envelope::Flat(1.0), Envelope::Edge(&levels));
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
        let config = config(lanes, SAMPLES);
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

/// A block of 3 V, and what the stack takes.
fn sense() -> SenseBlock {
    let mut drive = DriveBlock::silent(1, SAMPLES, 0);
    let wave = |n: usize| (2048.0 + 300.0 * sine::rotation((n as u64) << 59).im) as u16;
    drive.lanes[0] = (0..SAMPLES).map(wave).collect();
    let mut sense = SenseBlock::default();
    Transducer::new().exchange(&drive, &mut sense);
    sense
}

/// A stack, as identified.
const STACK: identify::Transducer = identify::Transducer {
    series_resonance_hz: 40_400.0,
    parallel_resonance_hz: 41_300.0,
    q: 65.0,
    rm_ohm: 3.0,
    lm_h: 0.79e-3,
    cm_f: 20e-9,
    c0_f: 300e-9,
    coupling: 0.25,
    deviations: identify::Deviations {
        series_resonance_hz: 0.0,
        parallel_resonance_hz: 0.0,
        q: 0.0,
        rm_ohm: 0.0,
        lm_h: 0.0,
        cm_f: 0.0,
        c0_f: 0.0,
        coupling: 0.0,
    },
    modes: 1,
    chosen: 0,
};
