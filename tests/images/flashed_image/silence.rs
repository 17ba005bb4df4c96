//! A fault that only the controller detects: both halves of the ring are silent as soon as it has
//! decided, before the end of the playing block.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use board::configure::load;
use board::recording::{Call, Replay, compare};
use board::{Board, Options};
use firmware::board::command::Command;
use firmware::controller::Controller;
use firmware::seam::block::{DriveBlock, dropped_from};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use hal_mock::tracer::DriveHash;
use link::client::Client;
use nucleo_g474re::blocks::{BLOCK, CYCLES_PER_SAMPLE};
use nucleo_g474re::config::SILENCE;
use scene::load::Loaded;
use sim::run::{Watch, run_on};
use stm32g474::Pin;

use super::{connected, elf, reaches};

/// Pin of the voltage channel.
const VOLTAGE: Pin = Pin::new('A', 0);
/// Duration of each run from its order.
const DURATION_SET: &str = "duration_s=0.25";
/// Duration for which the board runs.
const RUNS_FOR: Duration = Duration::from_millis(270);

/// Loads the scene of the dummy load with these changes.
fn changed(changes: &[&str]) -> Loaded {
    let changes: Vec<String> = changes.iter().chain(&[DURATION_SET]).map(|change| (*change).to_owned()).collect();
    load("dummy-load", &changes).expect("a built-in scene")
}

/// Returns a board of this scene that records its calls and was ordered to run, with this host
/// timeout, s.
fn ordered(elf: &[u8], loaded: &Loaded, timeout_s: f32) -> (Rc<RefCell<Board>>, Client) {
    let scene = loaded.scene.driven().expect("a driven scene");
    let options = Options { record: true, ..Options::default() };
    let (board, mut client) = connected(Board::start(elf, &scene, options).expect("the board starts"));
    client.connect().expect("an answer");
    client.order(Command::Patience(timeout_s)).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    (board, client)
}

/// Dropped queue.
#[derive(Debug)]
struct Dropped {
    fault: Option<Fault>,
    /// Samples from the end of the block that showed the fault to the first sample of silence.
    silent_from: usize,
    /// Time from the end of that block to the fall of the amplifier's enable, which the background
    /// task orders, us.
    enabled_us: f64,
}

/// Compares the codes at the DAC with the answers of the controller, and finds the dropped queue.
/// Also returns the calls, with the sample from which each was silent.
fn dropped(board: &Board) -> (Dropped, Vec<Call>) {
    let (mut calls, bench) = (board.calls.clone(), board.bench());
    let codes = bench.codes.as_deref().expect("recorded");
    assert_eq!(compare(&mut calls, codes), None, "except for the dropped queue, the DAC must play the returned codes");
    let mut controller = Controller::build(board.config()).expect("a valid configuration");
    let (mut drive, mut fault) = (controller.silence(), None);
    let call = calls.iter().position(|call| {
        fault = controller.process(&call.orders, &call.sense, &mut drive).fault;
        assert_eq!(drive, call.drive);
        drive.drops_queue
    });
    let call = call.expect("a dropped queue");
    let silent_from = calls[call].silent_from.expect("the block after it has played");
    let decided = (call + 1) * BLOCK;
    let (before, after) = codes.split_at(decided + silent_from);
    assert!(after.iter().all(|lanes| lanes[0] == SILENCE), "all later samples are silent");
    assert!(before[decided..].iter().any(|lanes| lanes[0] != SILENCE), "the board drives before");
    let fall = bench.edges.last().filter(|edge| !edge.high).expect("the enable falls");
    let ago = u64::from(CYCLES_PER_SAMPLE) * (bench.samples() - decided) as u64;
    let enabled_us = (fall.at as f64 - (board.machine().cycle() - ago) as f64) / f64::from(CYCLES_PER_SAMPLE);
    (Dropped { fault, silent_from, enabled_us }, calls)
}

/// Runs a scene until after its fault; `strike` is called when the board drives.
fn run(elf: &[u8], loaded: &Loaded, timeout_s: f32, strike: Option<fn(&mut Board)>) -> Rc<RefCell<Board>> {
    let (board, mut client) = ordered(elf, loaded, timeout_s);
    if let Some(strike) = strike {
        assert!(reaches(&mut client, &board, Mode::Run, Duration::from_millis(200)), "the board must lock");
        strike(&mut board.borrow_mut());
    }
    board.borrow_mut().run_for(RUNS_FOR).expect("no finding");
    board
}

/// Returns the hash of the codes at the DAC for this number of blocks from the first, in the format
/// of a run.
fn hash_of(board: &Board, first: usize, blocks: usize) -> u64 {
    let codes = board.bench().codes.as_deref().expect("recorded");
    let mut hash = DriveHash::default();
    for block in codes[first * BLOCK..].chunks_exact(BLOCK).take(blocks) {
        let mut drive = DriveBlock::silent(1, BLOCK, SILENCE);
        drive.lanes[0].iter_mut().zip(block).for_each(|(code, lanes)| *code = lanes[0]);
        hash.add(&drive);
    }
    hash.value()
}

#[test]
fn a_software_fault_silences_both_halves_at_once() {
    let Some(elf) = elf() else { return };
    let saturate = |board: &mut Board| {
        let at = board.machine().cycle() + 1000;
        board.bench_mut().tie(at, VOLTAGE, 3.3);
    };
    let on_time = changed(&["controller.limits.on_time_s=0.1"]);
    for (board, fault) in [
        (run(elf, &changed(&[]), 0.02, Some(|_| ())), Fault::HostLost),
        (run(elf, &changed(&[]), 0.0, Some(saturate)), Fault::SenseSaturated),
        (run(elf, &on_time, 0.0, None), Fault::OnTimeExceeded),
    ] {
        let (dropped, _) = dropped(&board.borrow());
        println!("{dropped:?} of {BLOCK}");
        assert_eq!(dropped.fault, Some(fault));
        assert!(dropped.silent_from <= dropped_from(BLOCK), "not later than a simulated board: {dropped:?}");
        assert!(dropped.enabled_us > dropped.silent_from as f64, "the background task acts later: {dropped:?}");
    }
}

#[test]
fn a_replay_is_silent_from_the_same_sample() {
    let Some(elf) = elf() else { return };
    let loaded = changed(&["controller.limits.on_time_s=0.1"]);
    let scene = loaded.scene.driven().expect("a driven scene");
    let board = run(elf, &loaded, 0.0, None);
    let mut board = board.borrow_mut();
    let ((Dropped { silent_from, .. }, calls), load) = (dropped(&board), board.take_load());
    let first = board.bench().first_block().expect("an order");
    // The amplifier was enabled while codes were played.
    assert_eq!(board.bench().first_lost, None);
    let mut replay = Replay::new(board.config(), calls, first, load, None).expect("the host returns what the image returned");
    let record = run_on(&mut replay, &scene, Watch::default()).expect("the plant returns the codes that the board sampled");
    assert_eq!(record.last.fault, Some(Fault::OnTimeExceeded));
    let dropped_s: f64 = record.rows.iter().map(|row| row.dropped_s).sum();
    assert!((dropped_s - (BLOCK - silent_from) as f64 * 1e-6).abs() < 1e-9, "{dropped_s} s");
    assert_eq!(record.drive_hash, hash_of(&board, first, record.rows.len()));
}
