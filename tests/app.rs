//! The background task and the controller as a whole, on mocks: what a board's user sees, without a board.
//!
//! On the loop-back nothing resonates, so the frequency is held: a run order leads through the self-test straight to running.
//! Drive codes are in samples since the first one played; the order of a run is given before the first block, unless a scenario
//! says otherwise.

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

/// The drive code at zero volts, and codes for a volt.
const MID: u16 = 2048;
const CODES_PER_VOLT: f64 = 100.0;
/// Samples in a block.
const BLOCK: usize = 32;
/// Blocks that certainly suffice for a self-test, and that are recorded of each run.
const PATIENCE: u64 = 200;
const KEEP: usize = 20_000;

/// The loop-back with everything a scenario may want to do to it or see of it.
type Load = Tracer<FaultInjector<LoopBack>>;

fn load(setup: &Setup) -> Load {
    load_of(setup, LoopBack::of(&setup.config))
}

fn load_of(setup: &Setup, load: LoopBack) -> Load {
    Tracer::new(FaultInjector::new(load, &setup.config.front_end, 1), KEEP)
}

fn setup(change: impl FnOnce(&mut Config)) -> Setup {
    let mut setup = Setup::default();
    change(&mut setup.config);
    setup
}

/// So many random cases, the same ones in every run.
fn cases(count: u32) -> Cases {
    Cases { cases: count, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Cases::default() }
}

/// A bench on which nothing has been ordered, whose host has begun a session.
fn bench<'a>(queues: &'a mut Queues, setup: &Setup) -> Bench<'a, Load> {
    let mut bench = strange(queues, setup);
    bench.connect();
    bench.host.forget();
    bench
}

/// A bench whose board has not been asked anything.
fn strange<'a>(queues: &'a mut Queues, setup: &Setup) -> Bench<'a, Load> {
    Bench::new(queues, setup, load(setup)).unwrap()
}

/// A bench that runs.
fn running<'a>(queues: &'a mut Queues, setup: &Setup) -> Bench<'a, Load> {
    let mut bench = bench(queues, setup);
    assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    assert!(bench.run_until(|report| report.mode == Mode::Run, PATIENCE).is_some(), "{:?}", bench.latest());
    // Measured blocks lag behind the reports; from here on both are the run's own.
    bench.blocks(4);
    bench
}

/// A bench that runs, with something broken from the beginning.
fn ordered_to_run_with<'a>(queues: &'a mut Queues, setup: &Setup, broken: &[FaultKind]) -> Bench<'a, Load> {
    let mut bench = bench(queues, setup);
    broken.iter().for_each(|&kind| bench.analog().inner.strike(kind));
    assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    bench
}

/// The codes that one lane has played since the beginning.
fn played(bench: &mut Bench<Load>, lane: usize) -> Vec<u16> {
    bench.analog().blocks().flat_map(|exchange| exchange.drive.lanes[lane].clone()).collect()
}

/// The codes of one lane over a run of so many blocks.
fn codes_of_run(setup: &Setup, blocks: u64) -> Vec<u16> {
    let mut queues = Queues::default();
    let mut bench = ordered_to_run_with(&mut queues, setup, &[]);
    bench.blocks(blocks);
    played(&mut bench, 0)
}

fn sounds(exchange: &Exchange) -> bool {
    exchange.drive.lanes.iter().flatten().any(|&code| code != MID)
}

/// The last block that was not silent.
fn last_sounding(bench: &mut Bench<Load>) -> Option<u64> {
    bench.analog().blocks().rfind(|exchange| sounds(exchange)).map(|exchange| exchange.block)
}

/// The largest distance from zero volts, in codes.
fn peak(codes: &[u16]) -> u16 {
    codes.iter().map(|&code| code.abs_diff(MID)).max().unwrap_or(0)
}

/// Amplitude in codes and phase in turns of a tone of `hz` in codes whose first is sample `from`, by correlation over the whole
/// periods that fit best.
fn tone(codes: &[u16], from: usize, hz: f64) -> (f64, f64) {
    let turn = hz / 1e6;
    let whole = ((codes.len() as f64 * turn).floor() / turn).round() as usize;
    let (mut re, mut im) = (0.0, 0.0);
    for (n, &code) in codes[..whole].iter().enumerate() {
        let angle = std::f64::consts::TAU * turn * (from + n) as f64;
        re += (f64::from(code) - f64::from(MID)) * angle.sin();
        im += (f64::from(code) - f64::from(MID)) * angle.cos();
    }
    (2.0 * re.hypot(im) / whole as f64, im.atan2(re) / std::f64::consts::TAU)
}
