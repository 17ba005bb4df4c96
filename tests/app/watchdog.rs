//! The watchdog is fed while blocks come, and only then.

use std::time::Duration;

use hal_mock::bench::{Queues, Setup};

use super::*;

#[test]
fn is_fed_while_blocks_come_whatever_the_mode() {
    let mut queues = Queues::default();
    let setup = Setup { poll_every: 8, watchdog: Duration::from_millis(1), ..Setup::default() };
    let mut bench = running(&mut queues, &setup);
    bench.blocks(2000);
    bench.analog().inner.strike(FaultKind::LateBlock);
    bench.blocks(2000);
    assert_eq!(bench.watchdog.bitten(), None);
}

#[test]
fn bites_within_its_time_when_the_block_stream_dies() {
    let mut queues = Queues::default();
    let setup = Setup { watchdog: Duration::from_millis(5), ..Setup::default() };
    let mut bench = running(&mut queues, &setup);
    let died = bench.clock.now();
    bench.stall(Duration::from_millis(4));
    assert_eq!(bench.watchdog.bitten(), None);
    bench.stall(Duration::from_millis(2));
    assert_eq!(bench.watchdog.bitten(), Some(died + setup.watchdog));
}
