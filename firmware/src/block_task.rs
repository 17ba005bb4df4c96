//! The hot side's end of the queues: what a board's DMA interrupt calls.

use crate::block::{DriveBlock, Orders, SenseBlock};
use crate::controller::Controller;
use crate::queues::HotEnds;

/// The controller with its queues.
pub struct BlockTask<'a> {
    controller: Controller,
    ends: HotEnds<'a>,
    /// Calibrations that the slow side has been told of.
    told: u32,
    latest: Orders,
}

impl<'a> BlockTask<'a> {
    /// A task that takes orders and leaves reports, and what else goes between the two sides.
    pub fn new(controller: Controller, ends: HotEnds<'a>) -> Self {
        let told = controller.calibrations();
        BlockTask { controller, ends, told, latest: Orders::default() }
    }

    /// A block of silence: what plays until the first call has returned.
    pub fn silence(&self) -> DriveBlock {
        self.controller.silence()
    }

    /// One block: the contract of [`Controller::process`]. Telemetry that the slow side has no room for is dropped; it sees the gap
    /// in the block numbers.
    pub fn run(&mut self, sense: &SenseBlock, drive: &mut DriveBlock) {
        // One order a block, so that none is skipped: a clear followed by a run must both be seen.
        if let Some(orders) = self.ends.orders.dequeue() {
            self.latest = orders;
        }
        if let Some(trims) = self.ends.taken.dequeue() {
            self.controller.trim(trims);
        }
        let telemetry = self.controller.process(&self.latest, sense, drive);
        self.tell_of_calibration();
        self.ends.recorder.follow(sense, drive, &telemetry);
        let _ = self.ends.reports.enqueue(telemetry);
    }

    /// Leaves the trims of a calibration that has been completed; where there is no room yet, with a later block.
    fn tell_of_calibration(&mut self) {
        let completed = self.controller.calibrations();
        if completed != self.told && self.ends.found.enqueue(self.controller.calibration().clone()).is_ok() {
            self.told = completed;
        }
    }
}
