//! The recorder: the block task's part of a capture. Disarmed it costs a block two comparisons; armed, four copies of a block of codes. What it
//! has recorded it gives away whole, so that nobody reads it in the block's time.

use heapless::spsc::{Consumer, Producer};

use super::memory::Memory;
use super::{Arm, CaptureReport, CaptureState, SAMPLES, Trigger};
use crate::seam::block::{DriveBlock, LATENCY_BLOCKS, SenseBlock};
use crate::seam::telemetry::Telemetry;

/// What the recorder is asked.
pub enum Wish {
    /// Record this, from now on; into this memory, where it does not have it still.
    Record(Arm, Option<&'static mut Memory>),
    /// How far is it? What is full comes with the answer.
    Look,
    /// Record no more, and give the memory back.
    Stop,
}

/// What it answers.
pub enum Answer {
    /// It records.
    Records,
    /// It is not full yet.
    Not(CaptureReport),
    /// It is full: the first sample stands there in the rings.
    Full(CaptureReport, usize, &'static mut Memory),
    /// It has stopped.
    Stopped(Option<&'static mut Memory>),
}

/// The recorder.
pub struct Recorder<'a> {
    wishes: Consumer<'a, Wish>,
    answers: Producer<'a, Answer>,
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
    /// What the trigger waits for was so in the last block; nobody knows in the first.
    was_so: Option<bool>,
    /// The trigger has come, and its first sample has not.
    met: bool,
    /// Samples before the trigger, and those that are still to come after it.
    before: usize,
    left: usize,
    block: u32,
}

impl<'a> Recorder<'a> {
    /// A recorder that takes wishes from one queue and leaves answers in another.
    pub fn new(wishes: Consumer<'a, Wish>, answers: Producer<'a, Answer>) -> Self {
        Recorder {
            wishes,
            answers,
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

    /// After each block: what it heard, what it returned, and its report.
    #[inline]
    pub fn follow(&mut self, sense: &SenseBlock, drive: &DriveBlock, report: &Telemetry) {
        if self.wishes.ready() {
            self.obey();
        }
        if matches!(self.state, CaptureState::Armed | CaptureState::Triggered) {
            self.record(sense, drive, report);
        }
    }

    #[inline(never)]
    fn obey(&mut self) {
        let answer = match self.wishes.dequeue() {
            Some(Wish::Record(arm, memory)) => {
                self.memory = self.memory.take().or(memory);
                self.arm = arm;
                self.begin();
                Answer::Records
            }
            Some(Wish::Look) => match self.memory.take_if(|_| self.state == CaptureState::Full) {
                // The rings are full: the first sample stands where the next one would go.
                Some(memory) => Answer::Full(self.report(), self.next, memory),
                None => Answer::Not(self.report()),
            },
            Some(Wish::Stop) => {
                self.state = CaptureState::Empty;
                Answer::Stopped(self.memory.take())
            }
            None => return,
        };
        // The slow side asks one thing at a time: there is room for the answer.
        let _ = self.answers.enqueue(answer);
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
