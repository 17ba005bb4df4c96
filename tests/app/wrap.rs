//! Wrap of the counters of the background task: block numbers wrap after 38 hours, frame numbers
//! after 65 536.

use firmware::board::app::{App, Peripherals};
use firmware::board::power_up::PowerUp;
use firmware::board::queues::BlockEnds;
use firmware::board::settings::Settings;
use firmware::board::start::Start;
use firmware::seam::fault::Fault;
use hal_mock::bench::{Queues, Setup};
use hal_mock::host::Host;
use hal_mock::link::{End, Wire, duplex};
use hal_mock::pin::{self, Input, Output};
use hal_mock::time::Clock;
use hal_mock::watchdog::Watchdog;

use super::*;

type Task<'a> = App<'a, End, Output, Input, Watchdog, hal_mock::flash::Flash>;

/// Returns a background task whose reports come from the test, with any block number.
fn task<'a>(queues: &'a mut Queues, clock: &Clock) -> (Task<'a>, BlockEnds<'a>, Host) {
    let setup = Setup::default();
    let mut settings = Settings::new(setup.flash.clone()).unwrap();
    let power_up = PowerUp::read(&setup.config, &mut settings);
    let (hot, slow) = queues.split(Box::leak(Box::default()));
    let (board_end, host_end) = duplex(Wire::default(), Wire::default());
    let peripherals = Peripherals {
        link: board_end,
        enable: pin::output(clock).0,
        stop: pin::input(true).0,
        watchdog: Watchdog::new(clock, setup.watchdog),
        settings,
        start: Start::PowerOn,
    };
    (App::new(peripherals, slow, &power_up), hot, Host::new(host_end))
}

/// Returns the blocks whose reports are sent, relative to the first block, and the block in which
/// the host counts as lost.
fn reports(first: u32) -> (Vec<u32>, Option<u32>) {
    let (clock, mut queues) = (Clock::new(1_000_000), Queues::default());
    let (mut app, mut block, mut host) = task(&mut queues, &clock);
    let mut lost = None;
    for n in 0..2000 {
        let Some(report) = block.read.dequeue() else { panic!("no report is free") };
        report.block = first.wrapping_add(n);
        // The run begins after the first frames of the host.
        report.mode = if n > 5 { Mode::Run } else { Mode::Idle };
        let Ok(()) = block.reports.enqueue(report) else { panic!("no room for a report") };
        match n {
            2 => drop(host.send(Command::Identify(1)).unwrap()),
            5 => drop(host.send(Command::TelemetryEvery(7)).unwrap()),
            // 32 ms are 1000 blocks.
            20 => drop(host.send(Command::Patience(0.032)).unwrap()),
            _ => {}
        }
        app.poll().unwrap();
        if n == 2 {
            host.receive(usize::MAX);
        }
        while let Some(orders) = block.orders.dequeue() {
            lost = lost.or(orders.host_lost.then_some(n));
        }
    }
    host.receive(usize::MAX);
    (host.telemetry().map(|(_, report)| report.block.wrapping_sub(first)).collect(), lost)
}

#[test]
fn telemetry_and_host_timeout_survive_a_wrap_of_the_block_number() {
    let far = reports(1000);
    assert_eq!((far.0.len(), far.0[0], far.0[1], far.1), (285, 5, 12, Some(1021)));
    for before in [1, 6, 12, 700, 1021] {
        assert_eq!(reports(u32::MAX - before), far, "{before} blocks before");
    }
}

#[test]
fn frame_numbers_wrap_without_a_gap() {
    const MORE: u64 = 70_000;
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    assert_eq!(bench.ask(Command::TelemetryEvery(1)), Some(Reply::Ack));
    bench.blocks(MORE);
    bench.host.receive(usize::MAX);
    let frames: Vec<(u16, u32)> = bench.host.telemetry().map(|(sequence, report)| (sequence, report.block)).collect();
    assert!(frames.len() as u64 >= MORE);
    for pair in frames.windows(2) {
        let [(before, block), (after, next)] = pair else { continue };
        assert_eq!((after.wrapping_sub(*before), next.wrapping_sub(*block)), (1, 1));
    }
    // Numbers of the host's frames: each command has its own answer, before and after the number
    // wraps.
    let mut queues = Queues::default();
    let mut bench = super::bench(&mut queues, &Setup::default());
    for _ in 0..300 {
        for _ in 0..218 {
            bench.host.send(Command::Status).unwrap();
        }
        bench.blocks(1);
        (0..300).for_each(|_| bench.poll());
        bench.host.receive(usize::MAX);
    }
    let answered: Vec<u16> = bench.host.answers().map(|(sequence, _)| sequence).collect();
    assert_eq!(answered.len(), 300 * 218);
    assert!(answered.windows(2).all(|pair| pair[1] == pair[0].wrapping_add(1)));
    assert_eq!((bench.fault(), bench.ask(Command::Run)), (None::<Fault>, Some(Reply::Ack)));
}
