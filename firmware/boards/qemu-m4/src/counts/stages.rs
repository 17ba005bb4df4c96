//! Stages of the controller, by their public functions.

use core::hint::black_box;

use firmware::block::DriveBlock;
use firmware::burst::Envelope;
use firmware::config::{Config, ShapeKind};
use firmware::convert::Convert;
use firmware::demod::{Sensed, demodulate};
use firmware::guard::{Driven, Guard};
use firmware::nco::tuning_word;
use firmware::phasor::Phasor;
use firmware::tracker::{Heard, Tracker};
use firmware::{phasing, shape, shaper};

use crate::controller::{config, sense};
use crate::counter::Counter;
use crate::image::line;

const SAMPLES: usize = 32;
const REPETITIONS: u32 = 1000;

pub fn count(counter: &Counter) {
    let config = config();
    let convert = Convert::build(&config.front_end).expect("a valid front end");
    let word = tuning_word(40_400.0 / 1e6);
    let sense = sense();
    let print = |kernel: &str, work: &mut dyn FnMut()| {
        line(kernel, SAMPLES, REPETITIONS, counter.count(REPETITIONS, work));
    };

    print("nothing", &mut || ());
    print("lock-in", &mut || {
        black_box(demodulate(black_box(&convert), black_box(&sense), black_box(1 << 60), black_box(word)));
    });

    let block_s = 32e-6;
    let mut guard = Guard::build(&config, block_s).expect("valid limits");
    let sensed = Sensed { v: Phasor::new(3.0, 0.0), i: Phasor::new(0.0, 0.15) };
    print("guard", &mut || {
        black_box(guard.inspect(
            black_box(&convert),
            black_box(&sense),
            black_box(&sensed),
            black_box(Driven { volts: Some(3.0) }),
        ));
    });
    print("clipped v", &mut || {
        black_box(convert.v.clipped(&black_box(&sense).v));
    });
    print("beyond i", &mut || {
        black_box(convert.i.beyond(&black_box(&sense).i, 3.0));
    });

    let mut tracker = tracker(&config, block_s);
    let heard = Heard { volts: 3.0, on: true, driven: true };
    let current = Phasor::new(1.0, 0.01);
    print("tracker", &mut || {
        black_box(tracker.follow(black_box(&sensed), black_box(current), black_box(&heard)));
    });

    let mut drive = DriveBlock::default();
    let levels = [0.5; SAMPLES];
    for (name, kind) in [("sine", ShapeKind::Sine), ("square", ShapeKind::Square)] {
        let table = shape::table(kind, 0.0424);
        for lanes in [1, 4] {
            let of = phasing::build(&config.phasing, lanes).expect("lanes");
            for (edge, envelope) in [("flat", Envelope::Flat(1.0)), ("edge", Envelope::Edge(&levels))] {
                let mut label = heapless::String::<40>::new();
                let _ = core::fmt::write(&mut label, format_args!("shaper {name} {lanes} {edge}"));
                print(&label, &mut || {
                    let at = (black_box(1 << 60), black_box(word), black_box(SAMPLES));
                    shaper::shape(&mut drive, &convert.drive, table, &of, at, black_box(3.0), black_box(&envelope));
                    black_box(&drive);
                });
            }
        }
    }
}

fn tracker(config: &Config, block_s: f32) -> Tracker {
    let mut tracking = config.clone();
    tracking.tracking.mode = firmware::config::TrackingMode::PhaseLock;
    let mut tracker = Tracker::build(&tracking, block_s).expect("valid tracking");
    let transducer = firmware::identify::Transducer {
        series_resonance_hz: 40_400.0,
        parallel_resonance_hz: 41_300.0,
        q: 65.0,
        rm_ohm: 3.0,
        lm_h: 0.79e-3,
        cm_f: 20e-9,
        c0_f: 300e-9,
    };
    tracker.seed(&transducer, firmware::motional::Motional::of_capacitance(300e-9, 40_400.0));
    tracker
}
