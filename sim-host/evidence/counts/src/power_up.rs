//! The controller as a whole: every block of a power-up on a transducer, from idle to bursts.
//!
//! Each call of `process` is counted for itself, to within a tick; the worst is such a count, the mean of many blocks is closer.

use core::fmt::Write as _;

use firmware::controller::Controller;
use firmware::seam::block::{DriveBlock, Orders, Request, SenseBlock};
use firmware::seam::config::{Edge, TrackingMode};
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use qemu_m4::bench::{SAMPLES, Transducer, config};
use qemu_m4::counter::Counter;

use crate::csv::line;

/// Blocks without orders.
const IDLE_BLOCKS: u32 = 100;
/// Blocks of the run: several bursts.
const RUN_BLOCKS: u32 = 1500;
/// A longer block, samples.
const LONG_BLOCK: usize = 64;
/// A power-up ends before this.
const MOST_BLOCKS: u32 = 30_000;

/// The block of the run in which the load comes, and how many blocks are counted one by one from then on. It comes where a burst is on.
const LOAD: (u32, u32) = (1100, 64);

/// What is powered up, and how.
#[derive(Clone)]
struct Trial {
    transducer: Transducer,
    tracking: TrackingMode,
    lanes: u8,
    samples: usize,
    edge: Edge,
    /// Gains of the lanes, none where they are alike.
    gains: &'static [f32],
}

/// Counts power-ups with one lane and with four, in blocks and in longer blocks; of a second resonance, of the phase loop behind a scan, and of boosted
/// bursts, only what differs. A trimmed lane is the exact opposite of no other lane.
pub fn count(counter: &Counter) {
    for (name, lanes, gains) in [("one lane", 1, &[][..]), ("four lanes", 4, &[]), ("four trimmed lanes", 4, &TRIMMED)] {
        for (length, samples) in [("", SAMPLES), (", 64 samples a block", LONG_BLOCK)] {
            let plain =
                Trial { transducer: Transducer::new(), tracking: TrackingMode::Observer, lanes, samples, edge: SOFT, gains };
            let print = |names: &[&str; KINDS], trial: &Trial| {
                for (kind, tally) in names.iter().zip(&power_up(counter, trial)) {
                    tally.print(name, kind, length, samples);
                }
            };
            print(&NAMES, &plain);
            print(&IN_COMPANY_NAMES, &Trial { transducer: Transducer::in_company(), ..plain.clone() });
            print(&PHASE_LOOP_NAMES, &Trial { tracking: TrackingMode::PhaseLock, ..plain.clone() });
            print(&BOOSTED_NAMES, &Trial { edge: Edge::Boost, ..plain });
        }
    }
}

/// Gains of four lanes of which none is like another.
const TRIMMED: [f32; 4] = [0.99, 1.0, 0.98, 0.97];
/// Number of kinds of blocks that are counted separately.
const KINDS: usize = 9;
/// The kind of a block: the mode that it begins in, and in a run the envelope as well.
const NAMES: [&str; KINDS] = [
    "idle",
    "self-test",
    "clamped branch",
    "lock",
    "run",
    "run at an edge",
    "run between bursts",
    "run after a step of the load",
    "",
];
/// The same, behind a scan and with the phase loop.
const PHASE_LOOP_NAMES: [&str; KINDS] =
    ["", "", "", "phase loop, lock", "phase loop, run", "phase loop, run at an edge", "", "", "scan"];

/// The clamped branch is measured.
const CLAMPED: usize = 2;
/// The same of a transducer with a second resonance.
const IN_COMPANY_NAMES: [&str; KINDS] = ["", "", "clamped branch, two resonances", "", "", "", "", "", ""];
/// The same in boosted bursts.
const BOOSTED_NAMES: [&str; KINDS] =
    ["", "", "", "", "boosted, run", "boosted, run at an edge", "boosted, run between bursts", "", ""];
/// Edges, unless they are boosted: they take eight periods.
const SOFT: Edge = Edge::Soft;

/// Running, the envelope one.
const RUN: usize = 4;
/// The load has just come.
const LOADED: usize = 7;

fn kind(mode: Mode, report: &Telemetry) -> usize {
    match mode {
        Mode::Idle | Mode::Fault => 0,
        Mode::SelfTest => 1,
        Mode::Clamped => CLAMPED,
        Mode::Lock => 3,
        Mode::Run if report.envelope == 1.0 => RUN,
        Mode::Run if report.envelope != 0.0 => 5,
        Mode::Run => 6,
        Mode::Scan | Mode::Calibrate => 8,
    }
}

/// Blocks of one kind.
#[derive(Clone, Copy, Default)]
struct Tally {
    blocks: u32,
    ticks: u32,
    worst: u32,
}

impl Tally {
    fn add(&mut self, ticks: u32) {
        self.blocks += 1;
        self.ticks += ticks;
        self.worst = self.worst.max(ticks);
    }

    /// Prints it, unless it has no name or there were none.
    fn print(&self, lanes: &str, kind: &str, length: &str, samples: usize) {
        if kind.is_empty() || self.blocks == 0 {
            return;
        }
        let mut name = heapless::String::<80>::new();
        // The longest of the names fits.
        let _ = write!(name, "{lanes}, {kind}{length}");
        line("process", &name, samples, self.blocks, self.ticks.into());
        line("worst block", &name, samples, 1, self.worst.into());
    }
}

/// Powers up and runs.
fn power_up(counter: &Counter, trial: &Trial) -> [Tally; KINDS] {
    let mut tallies = [Tally::default(); KINDS];
    let mut config = config(trial.tracking, trial.lanes, trial.samples);
    // One transducer at one lane: the others have no load.
    config.phasing.watch = false;
    config.burst.edge = trial.edge;
    config.phasing.gain_trim = trial.gains.iter().copied().collect();
    let mut controller = Controller::build(&config).expect("a valid configuration");
    let mut playing = [controller.silence(), controller.silence()];
    let (mut transducer, mut sense) = (trial.transducer.clone(), SenseBlock::default());
    let (mut mode, mut running, mut report) = (Mode::Idle, 0, Telemetry::default());
    for block in 0..MOST_BLOCKS {
        let drive: &mut DriveBlock = &mut playing[block as usize % 2];
        if running == LOAD.0 {
            transducer.load();
        }
        transducer.exchange(drive, &mut sense);
        let request = if block < IDLE_BLOCKS { Request::Idle } else { Request::Run };
        let orders = Orders { sequence: 1, request, attempt: 1, ..Orders::default() };
        let before = counter.now();
        controller.process_into(&orders, &sense, drive, &mut report);
        let ticks = counter.since(before);
        let loaded = (LOAD.0..LOAD.0 + LOAD.1).contains(&running);
        tallies[if loaded { LOADED } else { kind(mode, &report) }].add(ticks);
        mode = report.mode;
        assert!(mode != Mode::Fault, "{:?} in block {block}", report.fault);
        running += u32::from(mode == Mode::Run);
        if running == RUN_BLOCKS {
            return tallies;
        }
    }
    panic!("the controller does not come to run: {mode:?}")
}
