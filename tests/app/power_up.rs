//! Power-up: nothing is driven before an order.

use firmware::board::command::{Command, Converters, Identity, Reply};
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::mode::Mode;
use hal_mock::bench::{Queues, Setup};

use super::*;

#[test]
fn silent_at_mid_code_until_ordered() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    for command in [Command::Gate(Gate::On), Command::Amplitude(Some(Amplitude::Volts(5.0))), Command::ClearFault] {
        assert_eq!(bench.ask(command), Some(Reply::Ack));
        bench.blocks(300);
    }
    assert!(played(&mut bench, 0).iter().all(|&code| code == MID_CODE));
    assert_eq!((bench.mode(), bench.fault()), (Mode::Idle, None));
}

#[test]
fn the_enable_pin_is_low_from_the_first_turn() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    bench.poll();
    assert!(bench.enable.is_driven() && !bench.enable.is_high());
    bench.blocks(300);
    assert_eq!(bench.enable.changes().len(), 1);
}

#[test]
fn identify_is_answered_with_versions_before_any_block() {
    let mut queues = Queues::default();
    let mut bench = new_bench(&mut queues, &Setup::default());
    let version: Vec<u8> = env!("CARGO_PKG_VERSION").split('.').map(|part| part.parse().unwrap()).collect();
    let converters = Converters { sample_hz: 1_000_000, block_samples: 32, lanes: 1, sense_mid_code: 2048, drive_mid_code: 2048 };
    let answer = bench.ask(Command::Identify(7));
    let (protocol, session) = (firmware::board::link::VERSION, bench.host.session());
    let identity = Identity { protocol, firmware: version.try_into().unwrap(), converters, session };
    assert_eq!(answer, Some(Reply::Identity(identity)));
    assert_eq!(bench.played(), 0);
}
