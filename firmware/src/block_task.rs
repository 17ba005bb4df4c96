//! The hot side's end of the queues: what a board's DMA interrupt calls.

use heapless::spsc::{Consumer, Producer};

use crate::block::{DriveBlock, Orders, SenseBlock};
use crate::controller::Controller;
use crate::telemetry::Telemetry;

/// The controller with its queues.
pub struct BlockTask<'a> {
    controller: Controller,
    orders: Consumer<'a, Orders>,
    telemetry: Producer<'a, Telemetry>,
    latest: Orders,
}

impl<'a> BlockTask<'a> {
    /// A task that takes orders from one queue and leaves telemetry in the other.
    pub fn new(controller: Controller, orders: Consumer<'a, Orders>, telemetry: Producer<'a, Telemetry>) -> Self {
        BlockTask { controller, orders, telemetry, latest: Orders::default() }
    }

    /// A block of silence: what plays until the first call has returned.
    pub fn silence(&self) -> DriveBlock {
        self.controller.silence()
    }

    /// One block: the contract of [`Controller::process`]. Telemetry that the slow side has no room for is dropped; it sees the gap
    /// in the block numbers.
    pub fn run(&mut self, sense: &SenseBlock, drive: &mut DriveBlock) {
        // One order a block, so that none is skipped: a clear followed by a run must both be seen.
        if let Some(orders) = self.orders.dequeue() {
            self.latest = orders;
        }
        let telemetry = self.controller.process(&self.latest, sense, drive);
        let _ = self.telemetry.enqueue(telemetry);
    }
}
