//! The hot side's end of the queues: what a board's DMA interrupt calls.

use heapless::spsc::{Consumer, Producer};

use crate::block::{DriveBlock, Orders, SenseBlock};
use crate::config::LaneTrims;
use crate::controller::Controller;
use crate::telemetry::Telemetry;

/// Lane trims on their way between the two sides.
pub struct Exchange<'a> {
    /// What a calibration has found, to be kept.
    pub found: Producer<'a, LaneTrims>,
    /// What to trim by from now on; taken in silence only.
    pub taken: Consumer<'a, LaneTrims>,
}

/// The controller with its queues.
pub struct BlockTask<'a> {
    controller: &'a mut Controller,
    orders: Consumer<'a, Orders>,
    telemetry: Producer<'a, Telemetry>,
    trims: Exchange<'a>,
    /// Calibrations that the slow side has been told of.
    told: u32,
    latest: Orders,
}

impl<'a> BlockTask<'a> {
    /// A task that takes orders from one queue, leaves telemetry in another, and exchanges lane trims.
    pub fn new(
        controller: &'a mut Controller,
        orders: Consumer<'a, Orders>,
        telemetry: Producer<'a, Telemetry>,
        trims: Exchange<'a>,
    ) -> Self {
        let told = controller.calibrations();
        BlockTask { controller, orders, telemetry, trims, told, latest: Orders::default() }
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
        if let Some(trims) = self.trims.taken.dequeue() {
            self.controller.trim(trims);
        }
        let telemetry = self.controller.process(&self.latest, sense, drive);
        self.tell_of_calibration();
        let _ = self.telemetry.enqueue(telemetry);
    }

    /// Leaves the trims of a calibration that has been completed; where there is no room yet, with a later block.
    fn tell_of_calibration(&mut self) {
        let completed = self.controller.calibrations();
        if completed != self.told && self.trims.found.enqueue(self.controller.calibration().clone()).is_ok() {
            self.told = completed;
        }
    }
}
