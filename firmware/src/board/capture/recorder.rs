//! The recorder: the block task's part of a capture. It costs a block two comparisons when
//! disarmed, and four copies of a block of codes when armed. It passes on the full memory as a
//! whole, so that reading takes no time in a block.

use heapless::spsc::{Consumer, Producer};

use super::memory::Memory;
use super::{Arm, CaptureReport, CaptureState, SAMPLES, Trigger};
use crate::seam::block::{DriveBlock, LATENCY_BLOCKS, SenseBlock};
use crate::seam::telemetry::Telemetry;

/// Request to the recorder.
pub enum CaptureRequest {
    /// Starts to record with these settings. The memory comes along unless the recorder still owns
    /// it.
    Record(Arm, Option<&'static mut Memory>),
    /// Requests the state. A full memory comes with the reply.
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
    /// The capture is full: its report, the index of its first sample in the ring buffers, and the
    /// memory.
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
    /// Index of the next sample in the rings.
    next: usize,
    /// Number of samples before it, up to the length of the rings.
    filled: usize,
    /// Index of the older one of the blocks that have not played yet.
    older: usize,
    /// Number of blocks that have not played yet.
    coming: usize,
    /// `true` if the trigger's condition held in the last block; `None` before the first block.
    was_so: Option<bool>,
    /// `true` if the trigger has occurred, and its first sample is still to come.
    met: bool,
    /// Number of samples before the trigger.
    before: usize,
    /// Number of samples still to be recorded after the trigger.
    left: usize,
    block: u32,
}

impl<'a> Recorder<'a> {
    /// Creates a recorder that takes requests from one queue and leaves replies in another.
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

    /// Processes a block: the sampled codes, the returned codes, and the report.
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
                // The rings are full: the oldest sample is the one that would be overwritten next.
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
        let so = self.arm.trigger.holds_in(report);
        let changed = self.was_so == Some(false) || self.arm.trigger == Trigger::Now;
        self.met |= so && changed && self.state == CaptureState::Armed;
        self.was_so = Some(so);
        // The codes that play in the first blocks were returned before the capture was armed.
        if self.coming == LATENCY_BLOCKS {
            if self.met {
                self.trigger(report.block);
            }
            self.take(sense);
        } else {
            self.coming += 1;
        }
        if let (Some(memory), Some(lane)) = (&mut self.memory, drive.lanes.get(usize::from(self.arm.lane))) {
            memory.keep_coming(self.older, lane);
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

    /// Records the samples of a block; of the last block, as many as there is room for.
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
