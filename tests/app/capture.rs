//! Captures: the raw codes around a trigger are recorded exactly, and the capture has no other
//! effect.

use firmware::board::capture::{Arm, CaptureReport, CaptureState, CaptureVerb, PART, PARTS, Part, SAMPLES, Trigger};
use firmware::board::command::{Command, Reply};
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Bench, Queues, Setup};

use super::*;

/// Sends a request and plays blocks until it is answered. The block task gives the answer, so this
/// takes at least one block.
fn request(bench: &mut Bench<Load>, verb: CaptureVerb) -> Reply {
    let sequence = bench.host.send(Command::Capture(verb)).unwrap();
    for _ in 0..3 {
        bench.block();
        bench.host.receive(usize::MAX);
        if let Some(reply) = bench.host.answer_to(sequence) {
            return reply;
        }
    }
    panic!("no answer to {verb:?}");
}

fn arm(bench: &mut Bench<Load>, trigger: Trigger, before: u16, lane: u8) {
    assert_eq!(request(bench, CaptureVerb::Arm(Arm { trigger, before, lane })), Reply::Ack);
}

fn state(bench: &mut Bench<Load>) -> CaptureReport {
    match request(bench, CaptureVerb::State) {
        Reply::Capture(report) => report,
        other => panic!("{other:?}"),
    }
}

/// Waits until a capture is full and returns its voltage, current and drive.
fn codes(bench: &mut Bench<Load>) -> (CaptureReport, [Vec<u16>; 3]) {
    let full = (0..200).map(|_| state(bench)).find(|report| report.state == CaptureState::Full).expect("a capture");
    let mut codes = [vec![], vec![], vec![]];
    for number in 0..PARTS {
        let Reply::Captured(Part { part, v, i, drive }) = request(bench, CaptureVerb::Read(number)) else { panic!("no part") };
        assert_eq!(part, number);
        codes.iter_mut().zip([v, i, drive]).for_each(|(all, part)| all.extend(part));
    }
    (full, codes)
}

/// Returns the same codes from the record of the converters.
fn truth(bench: &mut Bench<Load>, report: &CaptureReport, lane: usize) -> [Vec<u16>; 3] {
    let block = bench.analog().blocks().next().unwrap().drive.lanes[0].len();
    let first = report.block as usize * block - usize::from(report.before);
    let mut all = |of: fn(&Exchange, usize) -> &[u16]| {
        let codes = bench.analog().blocks().flat_map(|exchange| of(exchange, lane).iter().copied());
        codes.skip(first).take(SAMPLES).collect::<Vec<u16>>()
    };
    // The tracer keeps a run from its first block.
    [
        all(|exchange, _| &exchange.sense.v),
        all(|exchange, _| &exchange.sense.i),
        all(|exchange, lane| &exchange.drive.lanes[lane]),
    ]
}

#[test]
fn a_capture_equals_the_codes_at_the_converters() {
    for block in [8, 24, 32, 63, 64] {
        for (trigger, before) in [
            (Trigger::Now, 0),
            (Trigger::On, 0),
            (Trigger::On, 333),
            (Trigger::Fault, 1),
            (Trigger::Fault, 1000),
            (Trigger::Fault, 1024),
        ] {
            let setup = setup(|config| config.block_samples = block);
            let mut queues = Queues::default();
            let mut bench = running(&mut queues, &setup);
            bench.ask(Command::Gate(Gate::Off));
            bench.blocks(7);
            arm(&mut bench, trigger, before, 0);
            bench.blocks(150);
            bench.ask(Command::Gate(Gate::On));
            bench.blocks(9);
            let report = state(&mut bench);
            if trigger == Trigger::Fault {
                assert_eq!((report.state, report.samples), (CaptureState::Armed, before), "{block}");
                bench.analog().inner.strike(FaultKind::LateBlock);
            }
            let (report, codes) = codes(&mut bench);
            assert_eq!(report.samples as usize, SAMPLES);
            assert_eq!(report.before, if trigger == Trigger::Now { 0 } else { before });
            assert_eq!(codes, truth(&mut bench, &report, 0), "{block} {trigger:?} {before}");
            // The loop-back samples its own drive in the same sample.
            assert_eq!(codes[0], codes[2], "{block} {trigger:?} {before}");
        }
    }
}

#[test]
fn the_trigger_is_the_block_that_reported_it() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.ask(Command::Gate(Gate::Off));
    bench.blocks(20);
    arm(&mut bench, Trigger::On, 100, 0);
    bench.blocks(20);
    bench.ask(Command::Gate(Gate::On));
    let until = bench.run_until(|report| report.envelope > 0.0, 10).map(|_| bench.latest().unwrap().block).unwrap();
    let (report, codes) = codes(&mut bench);
    assert_eq!((report.block, report.before), (until, 100));
    // It plays two blocks later, from its first zero crossing.
    let first = codes[2].iter().position(|&code| code != MID_CODE).unwrap();
    assert!((100 + 2 * BLOCK..100 + 3 * BLOCK).contains(&first), "{first}");
}

#[test]
fn a_fault_appears_in_the_first_sample_after_its_trigger() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    arm(&mut bench, Trigger::Fault, 512, 0);
    bench.blocks(100);
    bench.analog().inner.strike(FaultKind::Saturation);
    let (report, codes) = codes(&mut bench);
    assert_eq!((report.before, bench.mode()), (512, Mode::Fault));
    let Some(Reply::Faults(log)) = bench.ask(Command::Faults(0)) else { panic!("no log") };
    assert_eq!(log.entry.map(|entry| entry.block), Some(report.block));
    // The capture contains the drive before the fault, and the silence after it.
    assert!(peak(&codes[2][512..512 + 2 * BLOCK]) > 250);
    assert_eq!(peak(&codes[2][512 + 3 * BLOCK..]), 0);
}

#[test]
fn only_existing_lanes_can_be_recorded() {
    let setup = setup(|config| config.lanes = 4);
    for lane in 0..4 {
        let mut queues = Queues::default();
        let mut bench = running(&mut queues, &setup);
        arm(&mut bench, Trigger::Now, 0, lane);
        let (report, codes) = codes(&mut bench);
        assert_eq!(codes, truth(&mut bench, &report, lane.into()), "{lane}");
        assert_eq!(codes[0] == codes[2], lane == 0);
    }
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &setup);
    for (before, lane) in [(0, 4), (0, 255), (1025, 0), (u16::MAX, 0)] {
        let refused = request(&mut bench, CaptureVerb::Arm(Arm { trigger: Trigger::Now, before, lane }));
        assert_eq!((refused, state(&mut bench).state), (Reply::Nak(Refusal::OutOfRange), CaptureState::Empty));
    }
}

#[test]
fn missing_parts_are_refused() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    assert_eq!(state(&mut bench), CaptureReport::default());
    assert_eq!(request(&mut bench, CaptureVerb::Read(0)), Reply::Nak(Refusal::NotCaptured));
    arm(&mut bench, Trigger::Fault, 0, 0);
    assert_eq!(request(&mut bench, CaptureVerb::Read(0)), Reply::Nak(Refusal::NotCaptured));
    arm(&mut bench, Trigger::Now, 0, 0);
    bench.blocks(4);
    assert_eq!(state(&mut bench).state, CaptureState::Triggered);
    assert_eq!(request(&mut bench, CaptureVerb::Read(0)), Reply::Nak(Refusal::NotCaptured));
    codes(&mut bench);
    for part in [PARTS, PARTS + 1, u16::MAX] {
        assert_eq!(request(&mut bench, CaptureVerb::Read(part)), Reply::Nak(Refusal::OutOfRange), "{part}");
    }
    assert!(matches!(request(&mut bench, CaptureVerb::Read(PARTS - 1)), Reply::Captured(_)));
    assert_eq!(request(&mut bench, CaptureVerb::Disarm), Reply::Ack);
    assert_eq!(request(&mut bench, CaptureVerb::Read(0)), Reply::Nak(Refusal::NotCaptured));
    assert_eq!(usize::from(PARTS) * PART, SAMPLES);
}

#[test]
fn arming_restarts_and_a_full_capture_stays_until_then() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    arm(&mut bench, Trigger::Fault, 1000, 0);
    bench.blocks(100);
    assert_eq!(state(&mut bench).samples, 1000);
    arm(&mut bench, Trigger::Fault, 900, 0);
    let again = state(&mut bench);
    assert!(again.state == CaptureState::Armed && usize::from(again.samples) <= BLOCK, "{again:?}");
    arm(&mut bench, Trigger::Now, 0, 0);
    let (report, first) = codes(&mut bench);
    bench.ask(Command::Amplitude(Some(Amplitude::Volts(5.0))));
    bench.blocks(500);
    let (again, second) = codes(&mut bench);
    assert_eq!((report, first), (again, second));
}

#[test]
fn a_condition_that_is_already_true_is_not_a_trigger() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    arm(&mut bench, Trigger::On, 0, 0);
    bench.blocks(100);
    assert_eq!(state(&mut bench).state, CaptureState::Armed);
    bench.analog().inner.strike(FaultKind::LateBlock);
    bench.blocks(10);
    arm(&mut bench, Trigger::Fault, 0, 0);
    bench.blocks(100);
    assert_eq!((bench.fault(), state(&mut bench).state), (Some(Fault::LateBlock), CaptureState::Armed));
}

#[test]
fn a_second_request_is_refused_as_busy() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.ask(Command::TelemetryEvery(1));
    arm(&mut bench, Trigger::Now, 0, 0);
    bench.blocks(50);
    bench.host.receive(usize::MAX);
    bench.host.forget();
    let first = bench.host.send(Command::Capture(CaptureVerb::Read(3))).unwrap();
    assert!(matches!(bench.ask(Command::Identify(1)), Some(Reply::Identity(_))));
    assert_eq!(bench.ask(Command::Capture(CaptureVerb::State)), Some(Reply::Nak(Refusal::Busy)));
    assert_eq!(bench.host.answer_to(first), None);
    bench.blocks(2);
    bench.host.receive(usize::MAX);
    assert!(matches!(bench.host.answer_to(first), Some(Reply::Captured(Part { part: 3, .. }))));
    bench.blocks(20);
    bench.host.receive(usize::MAX);
    let blocks: Vec<u32> = bench.host.telemetry().map(|(_, report)| report.block).collect();
    assert!(blocks.len() >= 20 && blocks.windows(2).all(|pair| pair[1] == pair[0] + 1), "{blocks:?}");
}

#[test]
fn a_capture_changes_no_code() {
    let run = |captures: bool| {
        let mut queues = Queues::default();
        let mut bench = running(&mut queues, &Setup::default());
        if captures {
            arm(&mut bench, Trigger::Now, 0, 0);
            codes(&mut bench);
        }
        let rest = 500 - bench.played();
        bench.blocks(rest);
        bench.analog().hash()
    };
    assert_eq!(run(true), run(false));
}
