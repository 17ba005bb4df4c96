//! Background task and controller together, on mocks: the behaviour that a user of a board sees,
//! without a board.
//!
//! The loop-back has no resonance, so the frequency is held: an order to run leads through the
//! self-test directly to running. Drive codes are counted in samples from the first one played. The
//! order to run is given before the first block, unless a scenario states otherwise.

mod bank;
mod burst;
mod calibration;
mod capture;
mod determinism;
mod dropped_queue;
mod emergency_stop;
pub mod frame;
mod host_lost;
mod lanes;
mod limits;
mod link;
mod parameters;
mod power_up;
mod protection;
mod robustness;
mod run;
mod scan;
mod self_test;
mod session;
mod settings;
mod status;
mod stored_limits;
mod watchdog;
mod wrap;

use firmware::board::command::{Command, Reply};
use firmware::seam::config::Config;
use firmware::seam::mode::Mode;
use hal_mock::bench::{Bench, Queues, Setup};
use hal_mock::fault_injector::{FaultInjector, FaultKind};
use hal_mock::loop_back::LoopBack;
use hal_mock::tracer::{Exchange, Tracer};
use proptest::test_runner::{Config as Cases, RngSeed};

/// Drive code of zero volts.
const MID_CODE: u16 = 2048;
/// Drive codes per volt.
const CODES_PER_VOLT: f64 = 100.0;
/// Number of samples in a block.
const BLOCK: usize = 32;
/// Number of blocks that is sufficient for a self-test.
const STARTS_WITHIN: u64 = 200;
/// Number of recorded blocks of each run.
const RECORDED_BLOCKS: usize = 20_000;

/// Loop-back with fault injection and a record of its blocks.
type Load = Tracer<FaultInjector<LoopBack>>;

fn load(setup: &Setup) -> Load {
    load_of(setup, LoopBack::of(&setup.config))
}

fn load_of(setup: &Setup, load: LoopBack) -> Load {
    Tracer::new(FaultInjector::new(load, &setup.config.front_end, 1), RECORDED_BLOCKS)
}

fn setup(change: impl FnOnce(&mut Config)) -> Setup {
    let mut setup = Setup::default();
    change(&mut setup.config);
    setup
}

/// Returns a proptest configuration with this number of random cases, the same in every run.
fn cases(count: u32) -> Cases {
    Cases { cases: count, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Cases::default() }
}

/// Returns a bench without orders, whose host has begun a session.
fn bench<'a>(queues: &'a mut Queues, setup: &Setup) -> Bench<'a, Load> {
    let mut bench = new_bench(queues, setup);
    bench.connect();
    bench.host.forget();
    bench
}

/// Returns a bench whose board has not received a command yet.
fn new_bench<'a>(queues: &'a mut Queues, setup: &Setup) -> Bench<'a, Load> {
    Bench::new(queues, setup, load(setup)).unwrap()
}

/// Returns a bench that runs.
fn running<'a>(queues: &'a mut Queues, setup: &Setup) -> Bench<'a, Load> {
    let mut bench = bench(queues, setup);
    assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some(), "{:?}", bench.latest());
    // Measured blocks lag behind the reports; after four more blocks both belong to the run.
    bench.blocks(4);
    bench
}

/// Returns a bench that was ordered to run, with faults from the beginning.
fn ordered_to_run_with<'a>(queues: &'a mut Queues, setup: &Setup, broken: &[FaultKind]) -> Bench<'a, Load> {
    let mut bench = bench(queues, setup);
    broken.iter().for_each(|&kind| bench.analog().inner.strike(kind));
    assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    bench
}

/// Returns the codes that one lane has played since the beginning.
fn played(bench: &mut Bench<Load>, lane: usize) -> Vec<u16> {
    bench.analog().blocks().flat_map(|exchange| exchange.drive.lanes[lane].clone()).collect()
}

/// Returns the codes of one lane over a run of this number of blocks.
fn codes_of_run(setup: &Setup, blocks: u64) -> Vec<u16> {
    let mut queues = Queues::default();
    let mut bench = ordered_to_run_with(&mut queues, setup, &[]);
    bench.blocks(blocks);
    played(&mut bench, 0)
}

fn is_driven(exchange: &Exchange) -> bool {
    exchange.drive.lanes.iter().flatten().any(|&code| code != MID_CODE)
}

/// Returns the last block that was not silent.
fn last_driven(bench: &mut Bench<Load>) -> Option<u64> {
    bench.analog().blocks().rfind(|exchange| is_driven(exchange)).map(|exchange| exchange.block)
}

/// Returns the largest distance from zero volts, in codes.
fn peak(codes: &[u16]) -> u16 {
    codes.iter().map(|&code| code.abs_diff(MID_CODE)).max().unwrap_or(0)
}

/// Returns the amplitude (codes) and the phase (turns) of a tone of `hz` by correlation over the
/// longest run of whole periods. The first code is sample number `from`.
fn tone(codes: &[u16], from: usize, hz: f64) -> (f64, f64) {
    let turn = hz / 1e6;
    let whole = ((codes.len() as f64 * turn).floor() / turn).round() as usize;
    let (mut re, mut im) = (0.0, 0.0);
    for (n, &code) in codes[..whole].iter().enumerate() {
        let angle = std::f64::consts::TAU * turn * (from + n) as f64;
        re += (f64::from(code) - f64::from(MID_CODE)) * angle.sin();
        im += (f64::from(code) - f64::from(MID_CODE)) * angle.cos();
    }
    (2.0 * re.hypot(im) / whole as f64, im.atan2(re) / std::f64::consts::TAU)
}
