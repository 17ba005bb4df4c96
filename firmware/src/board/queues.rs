//! The queues between the background task and the block task, with the place of the controller. A
//! board has one set of them, as a static.
//!
//! Reports are not copied: they are in static memory and change owner. The block task fills a
//! report, passes it on, and takes back one that has been read.

use core::mem::MaybeUninit;

use heapless::spsc::{Consumer, Producer, Queue};

use crate::board::capture::memory::Memory;
use crate::board::capture::recorder::{CaptureReply, CaptureRequest, Recorder};
use crate::controller::Controller;
use crate::seam::block::Orders;
use crate::seam::config::LaneTrims;
use crate::seam::telemetry::Telemetry;

/// Length of a ring buffer for one element: one place stays empty.
const SINGLE_QUEUE_LENGTH: usize = 2;

/// Queues between the two tasks. Those of orders and reports hold one element less than `ORDERS`
/// and `REPORTS`.
pub struct Queues<const ORDERS: usize, const REPORTS: usize> {
    orders: Queue<Orders, ORDERS>,
    reports: Queue<&'static mut Telemetry, REPORTS>,
    read: Queue<&'static mut Telemetry, REPORTS>,
    trims_out: Queue<LaneTrims, SINGLE_QUEUE_LENGTH>,
    trims_in: Queue<LaneTrims, SINGLE_QUEUE_LENGTH>,
    requests: Queue<CaptureRequest, SINGLE_QUEUE_LENGTH>,
    replies: Queue<CaptureReply, SINGLE_QUEUE_LENGTH>,
    place: MaybeUninit<Controller>,
}

/// Static memory that one task lends to the other.
pub struct Loans<const REPORTS: usize> {
    capture: Memory,
    reports: [MaybeUninit<Telemetry>; REPORTS],
}

impl<const REPORTS: usize> Loans<REPORTS> {
    /// Creates memory without content.
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
    /// Report that is filled first.
    pub report: &'static mut Telemetry,
    /// Trims found by a calibration, to be stored.
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
    /// Trims found by a calibration.
    pub trims_out: Consumer<'a, LaneTrims>,
    /// Trims to use from now on.
    pub trims_in: Producer<'a, LaneTrims>,
    /// Requests to the recorder.
    pub requests: Producer<'a, CaptureRequest>,
    /// Replies of the recorder.
    pub replies: Consumer<'a, CaptureReply>,
    /// Memory of captures.
    pub memory: &'static mut Memory,
}

impl<const ORDERS: usize, const REPORTS: usize> Queues<ORDERS, REPORTS> {
    /// Creates empty queues, and a place without a controller.
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

    /// Splits the queues into their ends. The tasks pass the loans to each other.
    pub fn split(&mut self, loans: &'static mut Loans<REPORTS>) -> (BlockEnds<'_>, BackgroundEnds<'_>) {
        // A queue holds all reports but one, which the block task has from the beginning.
        const { assert!(REPORTS > 1, "needs one report to fill, and one to read") };
        let Loans { capture, reports } = loans;
        let (mut read_in, read_out) = self.read.split();
        let Some((first, others)) = reports.split_first_mut() else { unreachable!("`REPORTS` is at least two") };
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
