//! Events that switch the amplifier off: over-current trips, emergency stop, a short circuit; and
//! the test of the trips at start.

use std::time::Duration;

use board::Edge;
use firmware::board::command::{Command, Reply};
use firmware::board::start::{Start, TripFailure};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use nucleo_g474re::blocks::{BLOCK, CYCLES_PER_SAMPLE};
use nucleo_g474re::config::SILENCE;
use stm32g474::Pin;

use super::{connected, driving, driving_with, elf, powered, reaches};

/// Pin of the current at the positive trip.
const POSITIVE: Pin = Pin::new('A', 1);
/// Pin of the current at the negative trip.
const NEGATIVE: Pin = Pin::new('A', 7);
/// Processor cycles per microsecond, within which the hardware acts.
const CYCLES_PER_US: u64 = 170;
/// Duration of a block, s.
const BLOCK_S: f64 = BLOCK as f64 * 1e-6;
/// Duration of two blocks: the one in which the trip occurs, and that of the interrupt.
const TWO_BLOCKS: Duration = Duration::from_micros(2 * BLOCK as u64);

#[test]
fn the_emergency_stop_drops_the_enable_at_once() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = driving(elf);
    assert_eq!(
        board.borrow().bench().edges.iter().map(|edge| edge.high).collect::<Vec<_>>(),
        [true],
        "one rise without further pulses"
    );
    let pressed = board.borrow().machine().cycle();
    board.borrow_mut().bench_mut().press_stop(pressed);
    board.borrow_mut().run_for(Duration::from_millis(2)).expect("no finding");
    let edges = board.borrow().bench().edges.clone();
    let fall = edges.last().expect("an edge");
    assert!(!fall.high && fall.at - pressed < 170, "{edges:?}, pressed at {pressed}");
    let report = client.status().expect("an answer").expect("a report");
    assert_eq!((report.mode, report.fault), (Mode::Fault, Some(Fault::EmergencyStop)));
}

#[test]
fn an_over_current_drops_the_enable_in_hardware() {
    let Some(elf) = elf() else { return };
    // The limit of 3.5 A corresponds to pin voltages of 3.05 V and 0.25 V. Each comparator is
    // tested alone.
    for (pin, volts) in [(POSITIVE, 3.1), (NEGATIVE, 0.2)] {
        let (board, mut client) = driving(elf);
        let tripped = board.borrow().machine().cycle() + 1000;
        board.borrow_mut().bench_mut().tie(tripped, pin, volts);
        board.borrow_mut().run_for(TWO_BLOCKS).expect("no finding");
        let last: Edge = *board.borrow().bench().edges.last().expect("an edge");
        assert!(!last.high && last.at - tripped < CYCLES_PER_US, "{last:?}, tripped at {tripped}");
        assert_eq!(board.borrow().bench().code(), SILENCE, "mid-code from the next block");
        let report = client.status().expect("an answer").expect("a report");
        assert_eq!((report.mode, report.fault), (Mode::Fault, Some(Fault::OverCurrent)), "{pin} at {volts} V");
        assert_eq!(board.borrow().bench().edges.last(), Some(&last), "the enable must stay low");
    }
}

#[test]
fn the_trips_follow_the_stored_limit() {
    let Some(elf) = elf() else { return };
    // The scale is 0.4 V per ampere about 1.65 V. With a limit of 1 A, the trips act at 1.5 A, the
    // negative one later by its hysteresis. With the built-in limit of 3 A, they act at 3.5 A.
    let volts = |ampere: f64| 1.65 + 0.4 * ampere;
    let limited = ["controller.limits.current_a=1"];
    // The controller also drops the enable, but only at the end of the block.
    for (changes, ampere, trips) in
        [(&limited[..], 1.53, true), (&limited, -1.6, true), (&limited, 1.4, false), (&[], 1.53, false)]
    {
        let (board, mut client) = driving_with(elf, changes);
        let pin = if ampere > 0.0 { POSITIVE } else { NEGATIVE };
        let tripped = board.borrow().machine().cycle() + 1000;
        board.borrow_mut().bench_mut().tie(tripped, pin, volts(ampere));
        board.borrow_mut().run_for(Duration::from_micros(10)).expect("no finding");
        let fell = !board.borrow().bench().is_enabled();
        assert_eq!(fell, trips, "{ampere} A with {changes:?}");
        let last: Edge = *board.borrow().bench().edges.last().expect("an edge");
        assert!(!trips || last.at - tripped < CYCLES_PER_US, "{last:?}, tripped at {tripped}");
        if trips {
            board.borrow_mut().run_for(TWO_BLOCKS).expect("no finding");
            let report = client.status().expect("an answer").expect("a report");
            assert_eq!((report.mode, report.fault), (Mode::Fault, Some(Fault::OverCurrent)), "{ampere} A");
        }
    }
}

#[test]
fn a_short_circuit_is_muted_within_two_blocks() {
    let Some(elf) = elf() else { return };
    // The board drives after a scan of about 45 ms.
    let short = ["fault.0.kind=short", "fault.0.at_s=0.12", "duration_s=0.3"];
    let (board, mut client) = connected(powered(elf, &short));
    client.connect().expect("an answer");
    client.order(Command::Patience(0.0)).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    assert!(reaches(&mut client, &board, Mode::Run, Duration::from_millis(115)), "the board must lock");
    assert!(reaches(&mut client, &board, Mode::Fault, Duration::from_millis(150)), "the board must report a fault");
    let report = client.status().expect("an answer").expect("a report");
    assert_eq!(report.fault, Some(Fault::OverCurrent));
    let board = board.borrow();
    let bench = board.bench();
    let first_block = bench.first_block().expect("an order");
    let shorted = BLOCK * (first_block + (0.12 / BLOCK_S) as usize);
    let ago = |samples: usize| board.machine().cycle() - u64::from(CYCLES_PER_SAMPLE) * (bench.samples() - samples) as u64;
    let fall = bench.edges.last().expect("an edge");
    assert!(!fall.high && fall.at < ago(shorted + 2 * BLOCK) && fall.at > ago(shorted), "{fall:?}, shorted at {}", ago(shorted));
}

#[test]
fn a_missing_wire_to_the_negative_trip_is_found_at_start() {
    let Some(elf) = elf() else { return };
    let mut board = powered(elf, &[]);
    // The image pulls the pin down for a moment, and nothing else drives it.
    board.bench_mut().tie(0, NEGATIVE, 0.0);
    let (board, mut client) = connected(board);
    client.connect().expect("an answer");
    let answer = client.ask(Command::Faults(0)).expect("an answer");
    let failed = Start::TripFailed(TripFailure::Wire);
    assert!(matches!(answer, Reply::Faults(log) if log.last_run == failed), "{answer:?}");
    client.order(Command::Run).expect("acknowledged");
    assert!(reaches(&mut client, &board, Mode::Fault, Duration::from_millis(50)), "the board must report a fault");
    let report = client.status().expect("an answer").expect("a report");
    // The trip acts during the self-test, whose tone is far below the threshold.
    assert_eq!(report.fault, Some(Fault::LoadShorted));
    assert_eq!(board.borrow().bench().edges, [], "the enable never rises");
}
