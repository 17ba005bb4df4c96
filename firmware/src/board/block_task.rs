//! The block task: what a board's block interrupt calls, at its ends of the queues.

use core::mem;

use heapless::spsc::{Consumer, Producer};

use crate::board::capture::recorder::Recorder;
use crate::board::queues::BlockEnds;
use crate::controller::Controller;
use crate::seam::block::{DriveBlock, Orders, SenseBlock};
use crate::seam::config::{Config, LaneTrims};
use crate::seam::error::Error;
use crate::seam::telemetry::Telemetry;

/// The controller with its queues.
pub struct BlockTask<'a> {
    controller: &'a mut Controller,
    orders: Consumer<'a, Orders>,
    reports: Producer<'a, &'static mut Telemetry>,
    read: Consumer<'a, &'static mut Telemetry>,
    trims_out: Producer<'a, LaneTrims>,
    trims_in: Consumer<'a, LaneTrims>,
    recorder: Recorder<'a>,
    /// Calibrations that were reported to the background task.
    reported: u32,
    latest: Orders,
    /// The report that is being filled.
    report: &'static mut Telemetry,
}

impl<'a> BlockTask<'a> {
    /// Builds the controller in its place, and a task that takes orders and leaves reports, and what else goes between the two sides.
    pub fn build(config: &Config, ends: BlockEnds<'a>) -> Result<Self, Error> {
        let BlockEnds { place, orders, reports, read, report, trims_out, trims_in, recorder } = ends;
        let controller = Controller::build_in(place, config)?;
        let reported = controller.calibrations();
        Ok(BlockTask {
            controller,
            orders,
            reports,
            read,
            trims_out,
            trims_in,
            recorder,
            reported,
            latest: Orders::default(),
            report,
        })
    }

    /// A block of silence: what plays until the first call has returned.
    pub fn silence(&self) -> DriveBlock {
        self.controller.silence()
    }

    /// One block: the contract of [`Controller::process`]. Telemetry is dropped where the background task has not read any; the background task sees the gap
    /// in the block numbers.
    pub fn run(&mut self, sense: &SenseBlock, drive: &mut DriveBlock) {
        // One order a block, so that none is skipped: a clear followed by a run must both be seen.
        if let Some(orders) = self.orders.dequeue() {
            self.latest = orders;
        }
        if let Some(trims) = self.trims_in.dequeue() {
            self.controller.trim(trims);
        }
        self.controller.process_into(&self.latest, sense, drive, self.report);
        self.tell_of_calibration();
        self.recorder.follow(sense, drive, self.report);
        // As many are read as are in the queue or here: there is room for this one.
        if let Some(read) = self.read.dequeue() {
            let _ = self.reports.enqueue(mem::replace(&mut self.report, read));
        }
    }

    /// Leaves the trims of a calibration that has been completed; where there is no room yet, with a later block.
    fn tell_of_calibration(&mut self) {
        if self.controller.calibrations() != self.reported {
            self.tell();
        }
    }

    // Once in a calibration: the fast memory of a board has no room for it.
    #[cold]
    #[inline(never)]
    fn tell(&mut self) {
        if self.trims_out.enqueue(self.controller.calibration().clone()).is_ok() {
            self.reported = self.controller.calibrations();
        }
    }
}
