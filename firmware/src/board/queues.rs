//! The queues between the background task and the block task, with the place of the controller: a board has them once, as a static.
//!
//! Reports are not copied: they stand in static memory, and change hands. The block task fills one, leaves it, and takes one that has been read.

use core::mem::MaybeUninit;

use heapless::spsc::{Consumer, Producer, Queue};

use crate::board::capture::memory::Memory;
use crate::board::capture::recorder::{CaptureReply, CaptureRequest, Recorder};
use crate::controller::Controller;
use crate::seam::block::Orders;
use crate::seam::config::LaneTrims;
use crate::seam::telemetry::Telemetry;

/// One element, and the place that a ring buffer leaves empty.
const ONE: usize = 2;

/// The queues between the two tasks. Those of orders and of reports have room for one element less than their numbers say.
pub struct Queues<const ORDERS: usize, const REPORTS: usize> {
    orders: Queue<Orders, ORDERS>,
    reports: Queue<&'static mut Telemetry, REPORTS>,
    read: Queue<&'static mut Telemetry, REPORTS>,
    trims_out: Queue<LaneTrims, ONE>,
    trims_in: Queue<LaneTrims, ONE>,
    requests: Queue<CaptureRequest, ONE>,
    replies: Queue<CaptureReply, ONE>,
    place: MaybeUninit<Controller>,
}

/// Static memory that one task lends the other.
pub struct Loans<const REPORTS: usize> {
    capture: Memory,
    reports: [MaybeUninit<Telemetry>; REPORTS],
}

impl<const REPORTS: usize> Loans<REPORTS> {
    /// Memory in which nothing stands yet.
    pub const fn new() -> Self {
        Loans { capture: Memory::new(), reports: [const { MaybeUninit::uninit() }; REPORTS] }
    }
}

impl<const REPORTS: usize> Default for Loans<REPORTS> {
    fn default() -> Self {
        Loans::new()
    }
}

/// The ends of the queues that the [block task](crate::board::block_task::BlockTask) owns.
pub struct BlockEnds<'a> {
    /// Place of the controller.
    pub place: &'a mut MaybeUninit<Controller>,
    /// Orders to the controller.
    pub orders: Consumer<'a, Orders>,
    /// Telemetry of each block.
    pub reports: Producer<'a, &'static mut Telemetry>,
    /// Reports that have been read.
    pub read: Consumer<'a, &'static mut Telemetry>,
    /// The report that is filled first.
    pub report: &'static mut Telemetry,
    /// Trims that a calibration has found, to be stored.
    pub trims_out: Producer<'a, LaneTrims>,
    /// Trims to use from now on; taken in silence only.
    pub trims_in: Consumer<'a, LaneTrims>,
    /// The recorder of captures.
    pub recorder: Recorder<'a>,
}

/// The ends of the queues that the [background task](crate::board::app::App) owns.
pub struct BackgroundEnds<'a> {
    /// Orders to the controller.
    pub orders: Producer<'a, Orders>,
    /// Telemetry of each block.
    pub reports: Consumer<'a, &'static mut Telemetry>,
    /// Reports that have been read.
    pub read: Producer<'a, &'static mut Telemetry>,
    /// Trims that a calibration has found.
    pub trims_out: Consumer<'a, LaneTrims>,
    /// Trims to use from now on.
    pub trims_in: Producer<'a, LaneTrims>,
    /// Requests to the recorder.
    pub requests: Producer<'a, CaptureRequest>,
    /// Replies of the recorder.
    pub replies: Consumer<'a, CaptureReply>,
    /// The memory of captures.
    pub memory: &'static mut Memory,
}

impl<const ORDERS: usize, const REPORTS: usize> Queues<ORDERS, REPORTS> {
    /// Empty queues, and a place without a controller.
    pub const fn new() -> Self {
        Queues {
            orders: Queue::new(),
            reports: Queue::new(),
            read: Queue::new(),
            trims_out: Queue::new(),
            trims_in: Queue::new(),
            requests: Queue::new(),
            replies: Queue::new(),
            place: MaybeUninit::uninit(),
        }
    }

    /// Splits the queues into their ends; what is lent goes to and fro between the two tasks.
    pub fn split(&mut self, loans: &'static mut Loans<REPORTS>) -> (BlockEnds<'_>, BackgroundEnds<'_>) {
        // A queue holds one less than there are reports: this one is with the block task from the beginning.
        const { assert!(REPORTS > 1, "there is a report to fill, and one to read") };
        let Loans { capture, reports } = loans;
        let (mut read_in, read_out) = self.read.split();
        let Some((first, others)) = reports.split_first_mut() else { unreachable!("there are at least two") };
        for place in others {
            let _ = read_in.enqueue(place.write(Telemetry::default()));
        }
        let ((orders_in, orders_out), (reports_in, reports_out)) = (self.orders.split(), self.reports.split());
        let ((trims_out_in, trims_out_out), (trims_in_in, trims_in_out)) = (self.trims_out.split(), self.trims_in.split());
        let ((requests_in, requests_out), (replies_in, replies_out)) = (self.requests.split(), self.replies.split());
        let recorder = Recorder::new(requests_out, replies_in);
        let place = &mut self.place;
        let block = BlockEnds {
            place,
            orders: orders_out,
            reports: reports_in,
            read: read_out,
            report: first.write(Telemetry::default()),
            trims_out: trims_out_in,
            trims_in: trims_in_out,
            recorder,
        };
        let background = BackgroundEnds {
            orders: orders_in,
            reports: reports_out,
            read: read_in,
            trims_out: trims_out_out,
            trims_in: trims_in_in,
            requests: requests_in,
            replies: replies_out,
            memory: capture,
        };
        (block, background)
    }
}

impl<const ORDERS: usize, const REPORTS: usize> Default for Queues<ORDERS, REPORTS> {
    fn default() -> Self {
        Queues::new()
    }
}
