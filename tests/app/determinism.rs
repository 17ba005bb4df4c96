//! Determinism: a repeated run is identical bit for bit, and observers change nothing.

use firmware::board::command::Command;
use firmware::seam::block::{LATENCY_BLOCKS, dropped_from};
use hal_mock::analog::Analog;
use hal_mock::bench::{Bench, Queues, Setup};

use super::*;

fn hash_of_run(seed: u64, flips: f64) -> u64 {
    let setup = Setup::default();
    let mut queues = Queues::default();
    let injector = FaultInjector::new(LoopBack::of(&setup.config), &setup.config.front_end, seed);
    let mut bench = Bench::new(&mut queues, &setup, Tracer::new(injector, 0)).unwrap();
    bench.analog().inner.set_bit_flips(flips);
    bench.analog().inner.set_chance(FaultKind::LateBlock, if flips > 0.0 { 0.002 } else { 0.0 });
    bench.ask(Command::Run);
    bench.blocks(3000);
    bench.analog().hash()
}

#[test]
fn the_same_run_twice_plays_the_same_codes() {
    assert_eq!(hash_of_run(1, 0.0), hash_of_run(1, 0.0));
    assert_eq!(hash_of_run(1, 1e-3), hash_of_run(1, 1e-3));
}

#[test]
fn a_seed_matters_only_with_random_faults() {
    assert_eq!(hash_of_run(1, 0.0), hash_of_run(2, 0.0));
    assert_ne!(hash_of_run(1, 1e-3), hash_of_run(2, 1e-3));
}

fn last_codes<A: Analog>(analog: A, setup: &Setup, hash: impl Fn(&A) -> u64) -> u64 {
    let mut queues = Queues::default();
    let mut bench = Bench::new(&mut queues, setup, analog).unwrap();
    bench.ask(Command::Run);
    bench.blocks(1000);
    hash(bench.analog())
}

#[test]
fn inactive_middleware_can_be_nested_in_any_order() {
    let setup = Setup::default();
    let (load, front_end) = (LoopBack::of(&setup.config), &setup.config.front_end);
    let plain = last_codes(Tracer::new(load.clone(), 0), &setup, Tracer::hash);
    let outside = Tracer::new(FaultInjector::new(load.clone(), front_end, 3), 0);
    assert_eq!(last_codes(outside, &setup, Tracer::hash), plain);
    let inside = FaultInjector::new(Tracer::new(load.clone(), 7), front_end, 3);
    assert_eq!(last_codes(inside, &setup, |injector| injector.inner.hash()), plain);
    let twice = Tracer::new(FaultInjector::new(Tracer::new(FaultInjector::new(load, front_end, 3), 0), front_end, 4), 0);
    assert_eq!(
        last_codes(twice, &setup, |tracer| {
            assert_eq!(tracer.hash(), tracer.inner.inner.hash());
            tracer.hash()
        }),
        plain
    );
}

#[test]
fn the_pace_of_the_background_task_does_not_change_the_drive() {
    let hash = |poll_every| {
        let setup = Setup { poll_every, ..Setup::default() };
        last_codes(Tracer::new(LoopBack::of(&setup.config), 0), &setup, Tracer::hash)
    };
    assert_eq!((hash(7), hash(40)), (hash(1), hash(1)));
}

#[test]
fn a_run_replays_from_its_record() {
    // The controller's answers depend only on the orders and the sense blocks.
    let mut queues = Queues::default();
    let setup = Setup::default();
    let mut bench = ordered_to_run_with(&mut queues, &setup, &[]);
    bench.blocks(300);
    bench.analog().inner.strike(FaultKind::Saturation);
    bench.blocks(20);
    let record: Vec<Exchange> = bench.analog().blocks().cloned().collect();
    let mut controller = firmware::controller::Controller::build(&setup.config).unwrap();
    let orders =
        firmware::seam::block::Orders { sequence: 1, request: firmware::seam::block::Request::Run, ..Default::default() };
    let answer = |exchange: &Exchange| {
        let mut drive = controller.silence();
        controller.process(&orders, &exchange.sense, &mut drive);
        drive
    };
    let mut answers: Vec<_> = record.iter().map(answer).collect();
    let dropped: Vec<usize> = (1..answers.len()).filter(|&block| answers[block].drops_queue).map(|block| block - 1).collect();
    assert_eq!(dropped.len(), 1, "the saturation must drop the codes returned one block earlier");
    answers[dropped[0]].lanes.iter_mut().for_each(|codes| codes[dropped_from(BLOCK)..].fill(MID_CODE));
    for (block, (answer, later)) in answers.iter().zip(&record[LATENCY_BLOCKS..]).enumerate() {
        assert_eq!(*answer, later.drive, "block {block}");
    }
}
