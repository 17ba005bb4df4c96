//! Counts the whole controller: every block of a power-up on a transducer, from idle to bursts.
//!
//! Each call of `process` is counted on its own, to within a tick. The worst block is one such
//! count; the mean of many blocks is more exact.

use core::fmt::Write as _;

use firmware::controller::Controller;
use firmware::seam::block::{DriveBlock, Orders, Request, SenseBlock};
use firmware::seam::config::{Edge, TrackingMode};
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use qemu_m4::bench::{SAMPLES, Transducer, config};
use qemu_m4::counter::Counter;

use crate::csv::line;

/// Number of blocks before the order to run.
const IDLE_BLOCKS: u32 = 100;
/// Number of blocks of the run: several bursts.
const RUN_BLOCKS: u32 = 1500;
/// Length of a long block, samples.
const LONG_BLOCK: usize = 64;
/// Number of blocks within which a power-up must end.
const MAX_BLOCKS: u32 = 30_000;

/// Block of the run at which the load is applied, within a burst.
const LOAD_BLOCK: u32 = 1100;
/// Number of blocks after the load that are counted separately.
const LOADED_BLOCKS: u32 = 64;

/// Transducer and settings of one power-up.
#[derive(Clone)]
struct Trial {
    transducer: Transducer,
    tracking: TrackingMode,
    lanes: u8,
    samples: usize,
    edge: Edge,
    /// Gains of the lanes; empty if all are equal.
    gains: &'static [f32],
}

/// Counts power-ups with one lane, four lanes and four trimmed lanes, in short and in long blocks.
/// Variants with a second resonance, with the phase loop after a scan and with boosted bursts are
/// printed only in the kinds of blocks that differ. No trimmed lane is the exact opposite of
/// another.
pub fn count(counter: &Counter) {
    for (name, lanes, gains) in [("one lane", 1, &[][..]), ("four lanes", 4, &[]), ("four trimmed lanes", 4, &TRIMMED)] {
        for (length, samples) in [("", SAMPLES), (", 64 samples a block", LONG_BLOCK)] {
            let plain =
                Trial { transducer: Transducer::new(), tracking: TrackingMode::Observer, lanes, samples, edge: SOFT_EDGE, gains };
            let print = |names: &[&str; KINDS], trial: &Trial| {
                for (kind, tally) in names.iter().zip(&power_up(counter, trial)) {
                    tally.print(name, kind, length, samples);
                }
            };
            print(&NAMES, &plain);
            print(&TWO_MODES_NAMES, &Trial { transducer: Transducer::in_company(), ..plain.clone() });
            print(&PHASE_LOOP_NAMES, &Trial { tracking: TrackingMode::PhaseLock, ..plain.clone() });
            print(&BOOSTED_NAMES, &Trial { edge: Edge::Boost, ..plain });
        }
    }
}

/// Gains of four lanes, all different.
const TRIMMED: [f32; 4] = [0.99, 1.0, 0.98, 0.97];
/// Number of kinds of blocks that are counted separately.
const KINDS: usize = 9;
/// Names of the kinds of blocks: the mode in which a block begins and, in a run, the envelope.
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
/// Names of the kinds with the phase loop after a scan.
const PHASE_LOOP_NAMES: [&str; KINDS] =
    ["", "", "", "phase loop, lock", "phase loop, run", "phase loop, run at an edge", "", "", "scan"];

/// Kind of a block in which the clamped branch is measured.
const CLAMPED: usize = 2;
/// Names of the kinds of a transducer with a second resonance.
const TWO_MODES_NAMES: [&str; KINDS] = ["", "", "clamped branch, two resonances", "", "", "", "", "", ""];
/// Names of the kinds in boosted bursts.
const BOOSTED_NAMES: [&str; KINDS] =
    ["", "", "", "", "boosted, run", "boosted, run at an edge", "boosted, run between bursts", "", ""];
/// Edges of all other bursts: soft, eight periods long.
const SOFT_EDGE: Edge = Edge::Soft;

/// Kind of a block in a run with an envelope of one.
const RUN: usize = 4;
/// Kind of a block just after the load was applied.
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

/// Counts of the blocks of one kind.
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

    /// Prints the counts, unless the kind has no name or no blocks.
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

/// Powers up, runs, and returns the counts by kind.
fn power_up(counter: &Counter, trial: &Trial) -> [Tally; KINDS] {
    let mut tallies = [Tally::default(); KINDS];
    let mut config = config(trial.tracking, trial.lanes, trial.samples);
    // The transducer is at one lane; the others have no load.
    config.phasing.watch = false;
    config.burst.edge = trial.edge;
    config.phasing.gain_trim = trial.gains.iter().copied().collect();
    let mut controller = Controller::build(&config).expect("a valid configuration");
    let mut playing = [controller.silence(), controller.silence()];
    let (mut transducer, mut sense) = (trial.transducer.clone(), SenseBlock::default());
    let (mut mode, mut running, mut report) = (Mode::Idle, 0, Telemetry::default());
    for block in 0..MAX_BLOCKS {
        let drive: &mut DriveBlock = &mut playing[block as usize % 2];
        if running == LOAD_BLOCK {
            transducer.load();
        }
        transducer.exchange(drive, &mut sense);
        let request = if block < IDLE_BLOCKS { Request::Idle } else { Request::Run };
        let orders = Orders { sequence: 1, request, attempt: 1, ..Orders::default() };
        let before = counter.now();
        controller.process_into(&orders, &sense, drive, &mut report);
        let ticks = counter.since(before);
        let loaded = (LOAD_BLOCK..LOAD_BLOCK + LOADED_BLOCKS).contains(&running);
        tallies[if loaded { LOADED } else { kind(mode, &report) }].add(ticks);
        mode = report.mode;
        assert!(mode != Mode::Fault, "{:?} in block {block}", report.fault);
        running += u32::from(mode == Mode::Run);
        if running == RUN_BLOCKS {
            return tallies;
        }
    }
    panic!("the controller does not reach run: {mode:?}")
}
