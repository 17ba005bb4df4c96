//! The recorder: the block task's part of a capture. Disarmed it costs a block two comparisons; armed, four copies of a block of codes. What it
//! has recorded it hands over whole, so that no time of a block is spent on reading it.

use heapless::spsc::{Consumer, Producer};

use super::memory::Memory;
use super::{Arm, CaptureReport, CaptureState, SAMPLES, Trigger};
use crate::seam::block::{DriveBlock, LATENCY_BLOCKS, SenseBlock};
use crate::seam::telemetry::Telemetry;

/// Request to the recorder.
pub enum CaptureRequest {
    /// Records with these settings from now on, into this memory, unless the recorder still owns it.
    Record(Arm, Option<&'static mut Memory>),
    /// Asks for the state. A full memory comes with the reply.
    Look,
    /// Ends the recording and returns the memory.
    Stop,
}

/// Reply of the recorder.
pub enum CaptureReply {
    /// The recording has begun.
    Records,
    /// The capture is not full yet.
    Not(CaptureReport),
    /// The capture is full: its report, the place of its first sample in the ring buffers, and the memory.
    Full(CaptureReport, usize, &'static mut Memory),
    /// The recording has ended; the memory, if the recorder owned it.
    Stopped(Option<&'static mut Memory>),
}

/// The recorder of captures in the block task.
pub struct Recorder<'a> {
    requests: Consumer<'a, CaptureRequest>,
    replies: Producer<'a, CaptureReply>,
    memory: Option<&'static mut Memory>,
    arm: Arm,
    state: CaptureState,
    /// Where the next sample goes.
    next: usize,
    /// How many stand before it, as far as the rings go.
    filled: usize,
    /// Which of the coming blocks is the older one, and how many there are.
    older: usize,
    coming: usize,
    /// Whether the trigger's condition held in the last block; unknown in the first.
    was_so: Option<bool>,
    /// The trigger has come, and its first sample has not.
    met: bool,
    /// Samples before the trigger, and those that are still to come after it.
    before: usize,
    left: usize,
    block: u32,
}

impl<'a> Recorder<'a> {
    /// A recorder that takes requests from one queue and leaves replies in another.
    pub fn new(requests: Consumer<'a, CaptureRequest>, replies: Producer<'a, CaptureReply>) -> Self {
        Recorder {
            requests,
            replies,
            memory: None,
            arm: Arm { trigger: Trigger::Now, before: 0, lane: 0 },
            state: CaptureState::Empty,
            next: 0,
            filled: 0,
            older: 0,
            coming: 0,
            was_so: None,
            met: false,
            before: 0,
            left: 0,
            block: 0,
        }
    }

    /// Takes a block: the codes that were sampled, the codes that were returned, and its report.
    #[inline]
    pub fn follow(&mut self, sense: &SenseBlock, drive: &DriveBlock, report: &Telemetry) {
        if self.requests.ready() {
            self.obey();
        }
        if matches!(self.state, CaptureState::Armed | CaptureState::Triggered) {
            self.record(sense, drive, report);
        }
    }

    #[inline(never)]
    fn obey(&mut self) {
        let answer = match self.requests.dequeue() {
            Some(CaptureRequest::Record(arm, memory)) => {
                self.memory = self.memory.take().or(memory);
                self.arm = arm;
                self.begin();
                CaptureReply::Records
            }
            Some(CaptureRequest::Look) => match self.memory.take_if(|_| self.state == CaptureState::Full) {
                // The rings are full: the first sample stands where the next one would go.
                Some(memory) => CaptureReply::Full(self.report(), self.next, memory),
                None => CaptureReply::Not(self.report()),
            },
            Some(CaptureRequest::Stop) => {
                self.state = CaptureState::Empty;
                CaptureReply::Stopped(self.memory.take())
            }
            None => return,
        };
        // The background task sends one request at a time: there is room for the reply.
        let _ = self.replies.enqueue(answer);
    }

    fn begin(&mut self) {
        self.state = CaptureState::Armed;
        (self.next, self.filled, self.coming) = (0, 0, 0);
        (self.was_so, self.met) = (None, false);
        (self.before, self.left, self.block) = (0, SAMPLES, 0);
    }

    fn report(&self) -> CaptureReport {
        let samples = match self.state {
            CaptureState::Empty => 0,
            CaptureState::Armed => self.filled.min(self.arm.before.into()),
            CaptureState::Triggered | CaptureState::Full => SAMPLES - self.left,
        };
        let before = if self.state == CaptureState::Armed { samples } else { self.before };
        CaptureReport { state: self.state, samples: samples as u16, before: before as u16, block: self.block }
    }

    #[inline(never)]
    fn record(&mut self, sense: &SenseBlock, drive: &DriveBlock, report: &Telemetry) {
        let so = self.arm.trigger.is_so(report);
        let changed = self.was_so == Some(false) || self.arm.trigger == Trigger::Now;
        self.met |= so && changed && self.state == CaptureState::Armed;
        self.was_so = Some(so);
        // What plays in the first blocks was returned before anybody looked.
        if self.coming == LATENCY_BLOCKS {
            if self.met {
                self.trigger(report.block);
            }
            self.take(sense);
        } else {
            self.coming += 1;
        }
        if let (Some(memory), Some(lane)) = (&mut self.memory, drive.lanes.get(usize::from(self.arm.lane))) {
            memory.put_by(self.older, lane);
        }
        self.older = 1 - self.older;
        if drive.drops_queue
            && let (Some(memory), Some(lane)) = (&mut self.memory, drive.lanes.first())
            && let Some(&silence) = lane.first()
        {
            memory.drop_rest(self.older, lane.len(), silence);
        }
    }

    fn trigger(&mut self, block: u32) {
        self.met = false;
        self.state = CaptureState::Triggered;
        self.block = block;
        self.before = self.filled.min(self.arm.before.into());
        self.left = SAMPLES - self.before;
    }

    /// Takes the samples of a block; of the last one, as many as there is room for.
    #[inline]
    fn take(&mut self, sense: &SenseBlock) {
        let Some(memory) = &mut self.memory else { return };
        let triggered = self.state == CaptureState::Triggered;
        let count = if triggered { sense.v.len().min(self.left) } else { sense.v.len() };
        let whole = count == sense.v.len() && memory.take_block(self.next, &sense.v, &sense.i, self.older);
        if !whole && let (Some(v), Some(i)) = (sense.v.get(..count), sense.i.get(..count)) {
            memory.take(self.next, v, i, self.older);
        }
        self.next = (self.next + count) % SAMPLES;
        self.filled = (self.filled + count).min(SAMPLES);
        if triggered {
            self.left -= count;
            if self.left == 0 {
                self.state = CaptureState::Full;
            }
        }
    }
}
