//! Stages of the controller, by their public functions.

use core::fmt::Write as _;
use core::hint::black_box;

use firmware::block::{DriveBlock, SenseBlock};
use firmware::burst::Envelope;
use firmware::config::ShapeKind;
use firmware::convert::Convert;
use firmware::demod::{Sensed, demodulate};
use firmware::guard::{Driven, Guard};
use firmware::identify;
use firmware::motional::Motional;
use firmware::nco::tuning_word;
use firmware::phasor::Phasor;
use firmware::shape::sine;
use firmware::tracker::{Heard, Tracker};
use firmware::{phasing, shape, shaper};

use crate::bench::{SAMPLES, Transducer, config};
use crate::counter::Counter;
use crate::image::line;
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
    let config = config(4);
    let convert = Convert::build(&config.front_end).expect("a valid front end");
    let word = tuning_word(40_400.0 / 1e6);
    let sense = sense();

    print("lock-in", &mut || {
        black_box(demodulate(black_box(&convert), black_box(&sense), black_box(1 << 60), black_box(word)));
    });
    let sensed = Sensed { v: Phasor::new(3.0, 0.0), i: Phasor::new(1.0, 0.15) };
    let mut guard = Guard::build(&config, BLOCK_S).expect("valid limits");
    let driven = Driven { volts: Some(3.0) };
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

    let mut drive = DriveBlock::default();
    let levels = [0.5; SAMPLES];
    for (kind, of) in [("sine", ShapeKind::Sine), ("square", ShapeKind::Square)] {
        let table = shape::table(of, 0.0424);
        for lanes in [1, 4] {
            let of = phasing::build(&config.phasing, lanes).expect("lanes");
            for (when, envelope) in [("flat", Envelope::Flat(1.0)), ("at an edge", Envelope::Edge(&levels))] {
                let mut name = heapless::String::<48>::new();
                // The longest of the names fits.
                let _ = write!(name, "shaper, {kind}, {lanes} lanes, {when}");
                print(&name, &mut || {
                    let at = (black_box(1 << 60), black_box(word), black_box(SAMPLES));
                    shaper::shape(&mut drive, &convert.drive, table, &of, at, black_box(3.0), black_box(&envelope));
                    black_box(&drive);
                });
            }
        }
    }
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
};
