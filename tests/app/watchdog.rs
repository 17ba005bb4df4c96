//! The watchdog is fed only while blocks are served.

use std::time::Duration;

use hal_mock::bench::{Queues, Setup};

use super::*;

#[test]
fn is_fed_in_any_mode_while_blocks_are_served() {
    let mut queues = Queues::default();
    let setup = Setup { poll_every: 8, watchdog: Duration::from_millis(1), ..Setup::default() };
    let mut bench = running(&mut queues, &setup);
    bench.blocks(2000);
    bench.analog().inner.strike(FaultKind::LateBlock);
    bench.blocks(2000);
    assert_eq!(bench.watchdog.bitten(), None);
}

#[test]
fn expires_within_its_period_without_blocks() {
    let mut queues = Queues::default();
    let setup = Setup { watchdog: Duration::from_millis(5), ..Setup::default() };
    let mut bench = running(&mut queues, &setup);
    let died = bench.clock.now();
    bench.stall(Duration::from_millis(4));
    assert_eq!(bench.watchdog.bitten(), None);
    bench.stall(Duration::from_millis(2));
    assert_eq!(bench.watchdog.bitten(), Some(died + setup.watchdog));
}
