//! A fault drops the queued codes: the time that this saves, and the events that must not drop
//! them.

use firmware::board::command::Command;
use firmware::seam::block::{Gate, dropped_from};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use hal_mock::bench::{Queues, Setup};

use super::*;

/// Injects a fault of one block into a healthy run with blocks of this length. Returns the samples
/// from the beginning of that block to silence.
fn silent_after(samples: usize, kind: FaultKind) -> usize {
    let setup = setup(|config| config.block_samples = samples as u16);
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &setup);
    bench.blocks(100);
    let at = bench.played() as usize * samples;
    bench.analog().inner.strike(kind);
    bench.blocks(50);
    assert_eq!(bench.mode(), Mode::Fault, "{kind:?}");
    let codes = played(&mut bench, 0);
    codes.iter().rposition(|&code| code != MID_CODE).unwrap() + 1 - at
}

/// Returns the blocks of the run so far whose answer dropped the queue. Their codes play two blocks
/// later.
fn drops(bench: &mut Bench<Load>) -> Vec<u64> {
    bench.analog().blocks().filter(|exchange| exchange.drive.drops_queue).map(|exchange| exchange.block).collect()
}

#[test]
fn a_fault_is_silent_within_three_quarters_of_the_next_block() {
    for samples in [32, 100] {
        // Without the drop it would take two blocks. The last code before silence may be mid-code
        // itself.
        let after = samples + dropped_from(samples);
        for kind in [FaultKind::LateBlock, FaultKind::Dropout, FaultKind::Saturation, FaultKind::OverCurrentTrip] {
            let silent = silent_after(samples, kind);
            assert!((after - 1..=after).contains(&silent), "{kind:?}, blocks of {samples}: {silent}");
        }
    }
}

#[test]
fn only_the_block_that_enters_a_fault_drops_the_queue() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    // The end of a burst, a brake and the end of a run are played completely.
    for command in [Command::Gate(Gate::Off), Command::Gate(Gate::On), Command::Gate(Gate::Brake), Command::Idle] {
        bench.ask(command);
        bench.blocks(100);
    }
    assert_eq!(drops(&mut bench), Vec::<u64>::new());
    bench.ask(Command::Gate(Gate::On));
    bench.ask(Command::Run);
    assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some());
    bench.blocks(10);
    let at = bench.played();
    bench.analog().inner.strike(FaultKind::LateBlock);
    bench.blocks(100);
    assert_eq!(drops(&mut bench), [at + 2]);
}

#[test]
fn a_mute_by_the_belt_plays_the_queue() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    bench.analog().inner.inner.set_belt(Some(1));
    bench.ask(Command::Run);
    assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some());
    bench.blocks(300);
    bench.analog().inner.inner.set_belt(Some(0));
    bench.blocks(1000);
    assert_eq!((bench.fault(), drops(&mut bench)), (None, vec![]));
    assert!(last_driven(&mut bench).unwrap() < bench.played() - 500, "it must be muted");
}

#[test]
fn a_run_right_after_a_fault_has_no_fault() {
    // The dropped block is measured when the next attempt begins, or before. Later orders wait
    // until their blocks are measured.
    for blocks in 1..6 {
        let mut queues = Queues::default();
        let mut bench = running(&mut queues, &Setup::default());
        bench.blocks(100);
        bench.analog().inner.strike(FaultKind::LateBlock);
        bench.blocks(blocks);
        assert_eq!(bench.fault(), Some(Fault::LateBlock));
        bench.ask(Command::ClearFault);
        bench.ask(Command::Run);
        assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some(), "{blocks}: {:?}", bench.fault());
        bench.blocks(300);
        assert_eq!(bench.fault(), None, "{blocks}");
    }
}
