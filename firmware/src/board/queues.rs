//! The queues between the slow side and the block task, with the place of the controller: what a board has once, as a static.

use core::mem::MaybeUninit;

use heapless::spsc::{Consumer, Producer, Queue};

use crate::board::capture::memory::Memory;
use crate::board::capture::recorder::{Answer, Recorder, Wish};
use crate::controller::Controller;
use crate::seam::block::Orders;
use crate::seam::config::LaneTrims;
use crate::seam::telemetry::Telemetry;

/// One on its way, and the place that a ring keeps empty.
const ONE: usize = 2;

/// The queues. Those of orders and of reports have room for one less than their numbers say.
pub struct Queues<const ORDERS: usize, const REPORTS: usize> {
    orders: Queue<Orders, ORDERS>,
    reports: Queue<Telemetry, REPORTS>,
    found: Queue<LaneTrims, ONE>,
    taken: Queue<LaneTrims, ONE>,
    wishes: Queue<Wish, ONE>,
    answers: Queue<Answer, ONE>,
    place: MaybeUninit<Controller>,
}

/// What the [block task](crate::board::block_task::BlockTask) has of them.
pub struct HotEnds<'a> {
    /// Where the controller is to stand.
    pub place: &'a mut MaybeUninit<Controller>,
    /// Orders to obey.
    pub orders: Consumer<'a, Orders>,
    /// What each block reports.
    pub reports: Producer<'a, Telemetry>,
    /// What a calibration has found, to be kept.
    pub found: Producer<'a, LaneTrims>,
    /// What to trim by from now on; taken in silence only.
    pub taken: Consumer<'a, LaneTrims>,
    /// Records raw codes.
    pub recorder: Recorder<'a>,
}

/// What the [slow side](crate::board::app::App) has of them: the other ends.
pub struct SlowEnds<'a> {
    /// Orders to be obeyed.
    pub orders: Producer<'a, Orders>,
    /// What each block has reported.
    pub reports: Consumer<'a, Telemetry>,
    /// What a calibration has found.
    pub found: Consumer<'a, LaneTrims>,
    /// What is to be trimmed by.
    pub taken: Producer<'a, LaneTrims>,
    /// What the recorder is asked.
    pub wishes: Producer<'a, Wish>,
    /// What it answers.
    pub answers: Consumer<'a, Answer>,
    /// What it records into.
    pub memory: &'static mut Memory,
}

impl<const ORDERS: usize, const REPORTS: usize> Queues<ORDERS, REPORTS> {
    /// Empty queues.
    pub const fn new() -> Self {
        Queues {
            orders: Queue::new(),
            reports: Queue::new(),
            found: Queue::new(),
            taken: Queue::new(),
            wishes: Queue::new(),
            answers: Queue::new(),
            place: MaybeUninit::uninit(),
        }
    }

    /// Their ends; the memory of captures goes to and fro between them.
    pub fn split(&mut self, memory: &'static mut Memory) -> (HotEnds<'_>, SlowEnds<'_>) {
        let ((orders_in, orders_out), (reports_in, reports_out)) = (self.orders.split(), self.reports.split());
        let ((found_in, found_out), (taken_in, taken_out)) = (self.found.split(), self.taken.split());
        let ((wishes_in, wishes_out), (answers_in, answers_out)) = (self.wishes.split(), self.answers.split());
        let recorder = Recorder::new(wishes_out, answers_in);
        let place = &mut self.place;
        let hot = HotEnds { place, orders: orders_out, reports: reports_in, found: found_in, taken: taken_out, recorder };
        let slow = SlowEnds {
            orders: orders_in,
            reports: reports_out,
            found: found_out,
            taken: taken_in,
            wishes: wishes_in,
            answers: answers_out,
            memory,
        };
        (hot, slow)
    }
}

impl<const ORDERS: usize, const REPORTS: usize> Default for Queues<ORDERS, REPORTS> {
    fn default() -> Self {
        Queues::new()
    }
}
