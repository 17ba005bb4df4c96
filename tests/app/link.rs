//! Link: no input disturbs the block stream, and every valid command is obeyed and answered.

use firmware::board::command::{Command, Reply};
use firmware::board::link::{VERSION, encode};
use firmware::seam::block::{Gate, Target};
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Bench, ORDERS_DEPTH, Queues, Setup};
use hal_mock::chance::Chance;
use hal_mock::link::{WhenFull, Wire};
use proptest::prelude::*;

use super::frame::frame;
use super::*;

/// Sends bytes, gives the background task a turn, and returns all its answers.
fn answers_to(bench: &mut Bench<Load>, bytes: &[u8]) -> Vec<(u16, Reply)> {
    bench.host.forget();
    bench.host.send_bytes(bytes).unwrap();
    bench.poll();
    bench.host.receive(usize::MAX);
    bench.host.answers().map(|(sequence, reply)| (sequence, *reply)).collect()
}

#[test]
fn a_frame_with_a_flipped_bit_is_refused_and_the_next_obeyed() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    let session = bench.host.session();
    let (good, next) = (encode(7, session, Command::Run).unwrap(), encode(8, session, Command::Resonances).unwrap());
    for bit in 0..8 * (good.len() - 1) {
        let mut bytes = good.to_vec();
        bytes[bit / 8] ^= 1 << (bit % 8);
        bytes.extend_from_slice(&next);
        let answers = answers_to(&mut bench, &bytes);
        let ((sequence, last), damaged) = answers.split_last().unwrap();
        assert!(matches!((sequence, last), (8, Reply::Resonances(_))), "bit {bit}: {answers:?}");
        assert!(!damaged.is_empty(), "bit {bit}");
        assert!(damaged.iter().all(|(_, reply)| *reply == Reply::Nak(Refusal::Damaged)), "bit {bit}: {answers:?}");
    }
    bench.blocks(10);
    assert_eq!(bench.mode(), Mode::Idle);
}

#[test]
fn another_version_is_refused_with_any_body() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    let session = bench.host.session();
    for (version, body) in [(VERSION + 1, &[3][..]), (VERSION + 1, &[200; 40]), (0, &[]), (255, &[1, 2, 3])] {
        let answers = answers_to(&mut bench, &frame(version, 9, session, body));
        assert_eq!(answers, [(9, Reply::Nak(Refusal::Version))], "{version} {body:?}");
    }
    bench.blocks(10);
    assert_eq!(bench.mode(), Mode::Idle);
}

#[test]
fn a_valid_frame_without_a_command_is_refused_as_unknown() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    let session = bench.host.session();
    for body in [&[99][..], &[], &[4, 77], &[7]] {
        let answers = answers_to(&mut bench, &frame(VERSION, 9, session, body));
        assert_eq!(answers, [(9, Reply::Nak(Refusal::Unknown))], "{body:?}");
    }
}

#[test]
fn commands_without_their_configuration_are_refused() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    for command in [Command::Friction(Some(Target::Ratio(0.5))), Command::Occupant(Some(14.0))] {
        assert_eq!(bench.ask(command), Some(Reply::Nak(Refusal::NotConfigured)), "{command:?}");
    }
    // An order without a set point is always accepted.
    assert_eq!(bench.ask(Command::Friction(None)), Some(Reply::Ack));
}

#[test]
fn too_long_a_frame_is_refused_and_the_next_is_obeyed() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    let bytes = [&[0x55; 5000], &[0][..], &encode(3, bench.host.session(), Command::Gate(Gate::On)).unwrap()].concat();
    assert_eq!(answers_to(&mut bench, &bytes), [(0, Reply::Nak(Refusal::Damaged)), (3, Reply::Ack)]);
}

#[test]
fn a_command_may_arrive_byte_by_byte() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    for &byte in &encode(5, bench.host.session(), Command::Run).unwrap() {
        bench.host.send_bytes(&[byte]).unwrap();
        bench.blocks(3);
    }
    bench.host.receive(usize::MAX);
    assert_eq!((bench.host.answer_to(5), bench.mode()), (Some(Reply::Ack), Mode::SelfTest));
}

#[test]
fn orders_without_room_are_refused_as_busy_and_obeyed_later() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    assert!((0..ORDERS_DEPTH).all(|_| bench.ask(Command::Gate(Gate::Off)) == Some(Reply::Ack)));
    assert_eq!(bench.ask(Command::Run), Some(Reply::Nak(Refusal::Busy)));
    // A command that changes no orders needs no room.
    assert!(matches!(bench.ask(Command::Identify(1)), Some(Reply::Identity(_))));
    bench.block();
    assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    bench.blocks(ORDERS_DEPTH as u64 + 1);
    assert_eq!(bench.mode(), Mode::SelfTest);
}

#[test]
fn a_flood_of_garbage_does_not_disturb_the_block_stream() {
    let run = |flood: bool| {
        let mut queues = Queues::default();
        let mut bench = running(&mut queues, &Setup { poll_every: 4, ..Setup::default() });
        let mut chance = Chance::new(11);
        for _ in 0..1000 {
            if flood {
                let garbage: Vec<u8> = (0..100).map(|_| chance.byte()).collect();
                bench.host.send_bytes(&garbage).unwrap();
            }
            bench.block();
        }
        bench.host.send_bytes(&[0]).unwrap();
        bench.poll();
        bench.host.receive(usize::MAX);
        let refused = bench.host.answers().filter(|(_, reply)| matches!(reply, Reply::Nak(_))).count();
        let others = bench.host.answers().count() - refused;
        assert_eq!((bench.mode(), bench.errors(), bench.watchdog.bitten()), (Mode::Run, &[][..], None));
        assert!(matches!(bench.ask(Command::Identify(1)), Some(Reply::Identity(_))));
        (bench.analog().hash(), refused, others)
    };
    let ((quiet, none, _), (flooded, refused, others)) = (run(false), run(true));
    assert_eq!(flooded, quiet);
    // On average one byte in 256 is a zero, which ends a frame. Only the order to run was obeyed.
    assert!(none == 0 && refused > 300 && others == 1, "{none} {refused} {others}");
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn over_a_noisy_link_a_run_is_never_ordered_by_mistake(seed: u64, flip in 0.05..0.5, drop in 0.0..0.3) {
        let mut queues = Queues::default();
        let mut bench = bench(&mut queues, &Setup::default());
        bench.host.link.set_noise(seed, flip, drop);
        // None of these commands starts the drive, and no damage may turn one into a command that
        // does.
        for command in [Command::Idle, Command::ClearFault, Command::Gate(Gate::Off), Command::TelemetryEvery(0)].repeat(20) {
            bench.host.send(command).unwrap();
            bench.block();
        }
        prop_assert_eq!((bench.mode(), last_driven(&mut bench)), (Mode::Idle, None));
        bench.host.link.set_noise(seed, 0.0, 0.0);
        bench.host.send_bytes(&[0]).unwrap();
        prop_assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    }
}

/// Orders telemetry at this interval. Returns the block numbers and frame numbers of the telemetry
/// within `blocks` blocks.
fn telemetry(poll_every: u32, every: u32, blocks: u64) -> (Vec<u32>, Vec<u16>) {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup { poll_every, ..Setup::default() });
    bench.blocks(16);
    assert_eq!(bench.ask(Command::TelemetryEvery(every)), Some(Reply::Ack));
    bench.blocks(blocks);
    bench.host.receive(usize::MAX);
    assert_eq!(bench.host.frame_errors(), []);
    bench.host.telemetry().map(|(sequence, report)| (report.block, sequence)).unzip()
}

#[test]
fn telemetry_comes_at_the_ordered_rate_with_sequence_numbers() {
    let (blocks, sequences) = telemetry(1, 25, 1000);
    assert!(blocks.windows(2).all(|pair| pair[1] - pair[0] == 25), "{blocks:?}");
    assert!(sequences.iter().copied().eq(1..=sequences.len() as u16));
    assert!((40..=41).contains(&blocks.len()), "{}", blocks.len());
    assert!(telemetry(1, 0, 1000).0.is_empty());
    assert!((100..=101).contains(&telemetry(1, 1, 100).0.len()));
}

#[test]
fn telemetry_keeps_its_mean_rate_under_a_slow_background_task() {
    let (blocks, _) = telemetry(8, 100, 10_000);
    assert!((99..=102).contains(&blocks.len()), "{} frames", blocks.len());
}

#[test]
fn the_longest_interval_is_not_the_shortest() {
    for every in [1 << 31, u32::MAX] {
        let (blocks, _) = telemetry(1, every, 1000);
        assert!(blocks.len() <= 1, "{} frames", blocks.len());
    }
}

/// Returns a setup whose link transmits two bytes per block, 62.5 kB/s, and makes a writer wait
/// when 256 bytes are queued.
fn slow_link() -> Setup {
    Setup { to_host: Wire { capacity: Some(256), when_full: WhenFull::Waits }, ..Setup::default() }
}

#[test]
fn a_slow_link_drops_telemetry_but_no_answer() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &slow_link());
    bench.ask(Command::TelemetryEvery(1));
    let mut asked = Vec::new();
    for n in 0..4000 {
        if n % 200 == 0 {
            asked.push(bench.host.send(Command::Gate(Gate::On)).unwrap());
        }
        bench.block();
        bench.host.receive(2);
    }
    bench.host.receive(usize::MAX);
    assert!(asked.iter().all(|&sequence| bench.host.answer_to(sequence) == Some(Reply::Ack)));
    assert_eq!((bench.host.frame_errors(), bench.errors(), bench.mode()), (&[][..], &[][..], Mode::Run));
    let (sequences, blocks): (Vec<u16>, Vec<u32>) = bench.host.telemetry().map(|(n, report)| (n, report.block)).unzip();
    assert!((40..400).contains(&blocks.len()), "{}", blocks.len());
    assert!(sequences.windows(2).all(|pair| pair[1] == pair[0] + 1) && blocks.is_sorted());
}

#[test]
fn more_commands_than_room_for_answers_are_all_answered() {
    let mut queues = Queues::default();
    let narrow = Wire { capacity: Some(64), when_full: WhenFull::Refuses };
    let mut bench = bench(&mut queues, &Setup { to_host: narrow, ..Setup::default() });
    let asked: Vec<u16> = (0..200).map(|_| bench.host.send(Command::Identify(1)).unwrap()).collect();
    for _ in 0..1000 {
        bench.block();
        bench.host.receive(8);
    }
    assert!(bench.host.answers().map(|(sequence, _)| sequence).eq(asked));
    assert_eq!((bench.host.frame_errors(), bench.errors()), (&[][..], &[][..]));
}

#[test]
fn telemetry_never_makes_the_background_task_wait() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &slow_link());
    bench.ask(Command::TelemetryEvery(1));
    for _ in 0..2000 {
        bench.block();
        bench.host.receive(2);
    }
    assert_eq!(bench.host.link.inner.write_waits(), 0);
}

#[test]
fn a_host_that_stops_reading_does_not_stop_the_drive() {
    let mut queues = Queues::default();
    let setup = Setup { to_host: Wire { capacity: Some(1000), when_full: WhenFull::Refuses }, ..Setup::default() };
    let mut bench = running(&mut queues, &setup);
    bench.ask(Command::TelemetryEvery(1));
    bench.blocks(500);
    assert_eq!((bench.errors(), bench.mode()), (&[][..], Mode::Run));
    let edges: Vec<bool> = bench.enable.changes().iter().map(|change| change.high).collect();
    assert_eq!(edges, [false, true]);
}

#[test]
fn a_dead_link_disables_the_amplifier_and_leaves_it_disabled() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.host.link.inner.set_cut(true);
    bench.blocks(50);
    assert_eq!(bench.errors().len(), 50);
    let edges: Vec<bool> = bench.enable.changes().iter().map(|change| change.high).collect();
    assert_eq!(edges, [false, true, false]);
}
