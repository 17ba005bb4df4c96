//! The block task: the code that a board's block interrupt runs, at its ends of the queues.

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
    /// Number of calibrations reported to the background task.
    reported: u32,
    latest: Orders,
    /// Report that is being filled.
    report: &'static mut Telemetry,
}

impl<'a> BlockTask<'a> {
    /// Builds the controller in its place, and a task around it at its ends of the queues.
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

    /// Returns a block of silence, which plays until the first call has returned.
    pub fn silence(&self) -> DriveBlock {
        self.controller.silence()
    }

    /// Processes one block, by the contract of [`Controller::process`]. Telemetry is dropped while
    /// the background task has not read any; it detects the gap in the block numbers.
    pub fn run(&mut self, sense: &SenseBlock, drive: &mut DriveBlock) {
        // One order a block, so that none is skipped: a clear followed by a run must both act.
        if let Some(orders) = self.orders.dequeue() {
            self.latest = orders;
        }
        if let Some(trims) = self.trims_in.dequeue() {
            self.controller.trim(trims);
        }
        self.controller.process_into(&self.latest, sense, drive, self.report);
        self.report_calibration();
        self.recorder.follow(sense, drive, self.report);
        // The queue holds all reports but one: with one taken back, there is room for this one.
        if let Some(read) = self.read.dequeue() {
            let _ = self.reports.enqueue(mem::replace(&mut self.report, read));
        }
    }

    /// Passes on the trims of a completed calibration; if the queue is full, with a later block.
    fn report_calibration(&mut self) {
        if self.controller.calibrations() != self.reported {
            self.tell();
        }
    }

    // Once in a calibration: not worth its place in the fast memory of a board.
    #[cold]
    #[inline(never)]
    fn tell(&mut self) {
        if self.trims_out.enqueue(self.controller.calibration().clone()).is_ok() {
            self.reported = self.controller.calibrations();
        }
    }
}
