//! The recorder: the block task's part of a capture. Disarmed it costs a block two comparisons; armed, four copies of a block of codes.

use heapless::spsc::{Consumer, Producer};

use super::{Arm, CaptureReport, CaptureState, CaptureVerb, PART, PARTS, Part, SAMPLES, Trigger};
use crate::block::{DriveBlock, LATENCY_BLOCKS, MAX_BLOCK_SAMPLES, SenseBlock};
use crate::command::{Refusal, Reply};
use crate::telemetry::Telemetry;

/// A ring of samples.
type Ring = [u16; SAMPLES];

/// Room for a capture, in the RAM of a board.
pub struct Memory {
    v: Ring,
    i: Ring,
    drive: Ring,
    /// Codes that were returned and have not played yet.
    coming: [[u16; MAX_BLOCK_SAMPLES]; LATENCY_BLOCKS],
}

impl Memory {
    /// All zero.
    pub const fn new() -> Self {
        Memory { v: [0; SAMPLES], i: [0; SAMPLES], drive: [0; SAMPLES], coming: [[0; MAX_BLOCK_SAMPLES]; LATENCY_BLOCKS] }
    }
}

impl Default for Memory {
    fn default() -> Self {
        Memory::new()
    }
}

/// What the recorder answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// It is done.
    Done,
    /// It is not.
    Refused(Refusal),
    /// How far it is.
    Report(CaptureReport),
    /// A part.
    Part(Part),
}

impl From<Answer> for Reply {
    fn from(answer: Answer) -> Reply {
        match answer {
            Answer::Done => Reply::Ack,
            Answer::Refused(refusal) => Reply::Nak(refusal),
            Answer::Report(report) => Reply::Capture(report),
            Answer::Part(part) => Reply::Captured(part),
        }
    }
}

/// The recorder.
pub struct Recorder<'a> {
    memory: &'a mut Memory,
    wishes: Consumer<'a, CaptureVerb>,
    answers: Producer<'a, Answer>,
    arm: Arm,
    state: CaptureState,
    /// Where the next sample goes.
    next: usize,
    /// How many stand before it, as far as the ring goes.
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
    pub fn new(memory: &'a mut Memory, wishes: Consumer<'a, CaptureVerb>, answers: Producer<'a, Answer>) -> Self {
        Recorder {
            memory,
            wishes,
            answers,
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
            self.obey(drive.lanes.len());
        }
        if matches!(self.state, CaptureState::Armed | CaptureState::Triggered) {
            self.record(sense, drive, report);
        }
    }

    #[inline(never)]
    fn obey(&mut self, lanes: usize) {
        // The slow side asks one thing at a time: there is room for the answer.
        let Some(wish) = self.wishes.dequeue() else { return };
        let answer = match wish {
            CaptureVerb::Arm(arm) if usize::from(arm.before) > SAMPLES || usize::from(arm.lane) >= lanes => {
                Answer::Refused(Refusal::OutOfRange)
            }
            CaptureVerb::Arm(arm) => {
                self.begin(CaptureState::Armed);
                self.arm = arm;
                Answer::Done
            }
            CaptureVerb::Disarm => {
                self.begin(CaptureState::Empty);
                Answer::Done
            }
            CaptureVerb::State => Answer::Report(self.report()),
            CaptureVerb::Read(_) if self.state != CaptureState::Full => Answer::Refused(Refusal::NotCaptured),
            CaptureVerb::Read(part) if part >= PARTS => Answer::Refused(Refusal::OutOfRange),
            CaptureVerb::Read(part) => Answer::Part(self.part(part)),
        };
        let _ = self.answers.enqueue(answer);
    }

    fn begin(&mut self, state: CaptureState) {
        self.state = state;
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

    /// A part of a full capture: the ring is full, and its first sample is where the next would go.
    fn part(&self, number: u16) -> Part {
        let first = (self.next + usize::from(number) * PART) % SAMPLES;
        let mut part = Part { part: number, ..Part::default() };
        read(&self.memory.v, first, &mut part.v);
        read(&self.memory.i, first, &mut part.i);
        read(&self.memory.drive, first, &mut part.drive);
        part
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
        let lane = drive.lanes.get(usize::from(self.arm.lane)).map_or(&[][..], |lane| lane);
        self.memory.coming[self.older][..lane.len()].copy_from_slice(lane);
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
    fn take(&mut self, sense: &SenseBlock) {
        let Memory { v, i, drive, coming } = &mut *self.memory;
        let triggered = self.state == CaptureState::Triggered;
        let count = sense.v.len().min(sense.i.len()).min(if triggered { self.left } else { SAMPLES });
        write(v, self.next, &sense.v[..count]);
        write(i, self.next, &sense.i[..count]);
        write(drive, self.next, &coming[self.older][..count]);
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

/// Writes codes into a ring from a place on.
fn write(ring: &mut Ring, at: usize, codes: &[u16]) {
    let (front, back) = codes.split_at(codes.len().min(SAMPLES - at));
    ring[at..at + front.len()].copy_from_slice(front);
    if !back.is_empty() {
        ring[..back.len()].copy_from_slice(back);
    }
}

/// Reads codes from a place of a ring on.
fn read(ring: &Ring, at: usize, codes: &mut [u16; PART]) {
    let (front, back) = codes.split_at_mut(PART.min(SAMPLES - at));
    front.copy_from_slice(&ring[at..at + front.len()]);
    back.copy_from_slice(&ring[..back.len()]);
}
