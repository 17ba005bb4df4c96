//! The controller as a whole: every block of a power-up on a transducer, from idle to bursts.
//!
//! Each call of `process` is counted for itself, to within a tick; the worst is such a count, the mean of many blocks is closer.

use core::fmt::Write as _;

use firmware::block::{DriveBlock, Orders, Request, SenseBlock};
use firmware::controller::Controller;
use firmware::supervisor::Mode;
use firmware::telemetry::Telemetry;

use crate::bench::{SAMPLES, Transducer, config};
use crate::counter::Counter;
use crate::csv::line;

/// Blocks without orders.
const IDLE_BLOCKS: u32 = 100;
/// Blocks of the run: several bursts.
const RUN_BLOCKS: u32 = 1500;
/// A longer block, samples.
const LONG_BLOCK: usize = 64;
/// A power-up ends before this.
const MOST_BLOCKS: u32 = 30_000;

/// Counts power-ups with one lane and with four; of longer blocks only the run.
pub fn count(counter: &Counter) {
    for (name, lanes) in [("one lane", 1), ("four lanes", 4)] {
        let tallies = power_up(counter, lanes, SAMPLES);
        for (kind, tally) in NAMES.iter().zip(&tallies) {
            tally.print(name, kind, SAMPLES);
        }
        power_up(counter, lanes, LONG_BLOCK)[RUN].print(name, "run, 64 samples a block", LONG_BLOCK);
    }
}

/// What is told apart: the mode a block begins in, and in a run what the envelope is.
const NAMES: [&str; 7] = ["idle", "self-test", "scan", "lock", "run", "run at an edge", "run between bursts"];

/// Running, the envelope one.
const RUN: usize = 4;

fn kind(mode: Mode, report: &Telemetry) -> usize {
    match mode {
        Mode::Idle | Mode::Fault => 0,
        Mode::SelfTest => 1,
        Mode::Scan | Mode::Calibrate => 2,
        Mode::Lock => 3,
        Mode::Run if report.envelope == 1.0 => RUN,
        Mode::Run if report.envelope > 0.0 => 5,
        Mode::Run => 6,
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

    fn print(&self, lanes: &str, kind: &str, samples: usize) {
        let mut name = heapless::String::<48>::new();
        // The longest of the names fits.
        let _ = write!(name, "{lanes}, {kind}");
        line("process", &name, samples, self.blocks, self.ticks.into());
        line("worst block", &name, samples, 1, self.worst.into());
    }
}

/// Powers up and runs.
fn power_up(counter: &Counter, lanes: u8, samples: usize) -> [Tally; NAMES.len()] {
    let mut tallies = [Tally::default(); NAMES.len()];
    let mut controller = Controller::build(&config(lanes, samples)).expect("a valid configuration");
    let mut playing = [controller.silence(), controller.silence()];
    let (mut transducer, mut sense) = (Transducer::new(), SenseBlock::default());
    let (mut mode, mut running) = (Mode::Idle, 0);
    for block in 0..MOST_BLOCKS {
        let drive: &mut DriveBlock = &mut playing[block as usize % 2];
        transducer.exchange(drive, &mut sense);
        let request = if block < IDLE_BLOCKS { Request::Idle } else { Request::Run };
        let orders = Orders { sequence: 1, request, attempt: 1, ..Orders::default() };
        let before = counter.now();
        let report = controller.process(&orders, &sense, drive);
        let ticks = counter.since(before);
        tallies[kind(mode, &report)].add(ticks);
        mode = report.mode;
        assert!(mode != Mode::Fault, "{:?} in block {block}", report.fault);
        running += u32::from(mode == Mode::Run);
        if running == RUN_BLOCKS {
            return tallies;
        }
    }
    panic!("the controller does not come to run: {mode:?}")
}
