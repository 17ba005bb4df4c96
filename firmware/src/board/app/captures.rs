//! The slow side of captures: what is asked of the recorder, and what is read of what it has given.

use heapless::spsc::{Consumer, Producer};

use crate::board::capture::memory::Memory;
use crate::board::capture::recorder::{Answer, Wish};
use crate::board::capture::{Arm, CaptureReport, CaptureVerb, PARTS, SAMPLES};
use crate::board::command::Reply;
use crate::seam::refusal::Refusal;

/// Captures, as the slow side knows them.
pub(super) struct Captures<'a> {
    wishes: Producer<'a, Wish>,
    answers: Consumer<'a, Answer>,
    lanes: u8,
    /// The memory, while the recorder does not have it.
    memory: Option<&'static mut Memory>,
    /// What it is full of, and where the first sample stands in it.
    full: Option<(CaptureReport, usize)>,
    /// What waits for an answer, with the number of its frame.
    asked: Option<(u16, CaptureVerb)>,
}

impl<'a> Captures<'a> {
    /// Nothing is recorded yet.
    pub(super) fn new(wishes: Producer<'a, Wish>, answers: Consumer<'a, Answer>, memory: &'static mut Memory, lanes: u8) -> Self {
        Captures { wishes, answers, lanes, memory: Some(memory), full: None, asked: None }
    }

    /// Obeys a command; `None` where its answer comes with a later block.
    pub(super) fn obey(&mut self, sequence: u16, verb: CaptureVerb) -> Option<Reply> {
        let here = self.memory.is_some();
        let wish = match verb {
            _ if self.asked.is_some() || !self.wishes.ready() => return Some(Reply::Nak(Refusal::Busy)),
            CaptureVerb::Arm(arm) if !self.is_possible(arm) => return Some(Reply::Nak(Refusal::OutOfRange)),
            CaptureVerb::Arm(arm) => {
                self.full = None;
                Wish::Record(arm, self.memory.take())
            }
            CaptureVerb::State if here => return Some(Reply::Capture(self.report())),
            CaptureVerb::Read(part) if here => return Some(self.read(part)),
            CaptureVerb::Disarm if here => {
                self.full = None;
                return Some(Reply::Ack);
            }
            CaptureVerb::State | CaptureVerb::Read(_) => Wish::Look,
            CaptureVerb::Disarm => Wish::Stop,
        };
        self.asked = Some((sequence, verb));
        // There is room: the last one was answered.
        let _ = self.wishes.enqueue(wish);
        None
    }

    /// The answer to an earlier command, with the number of its frame, once it has come.
    pub(super) fn answer(&mut self) -> Option<(u16, Reply)> {
        let answer = self.answers.dequeue()?;
        let (sequence, verb) = self.asked.take()?;
        let reply = match answer {
            Answer::Records => Reply::Ack,
            Answer::Not(report) if verb == CaptureVerb::State => Reply::Capture(report),
            Answer::Not(_) => Reply::Nak(Refusal::NotCaptured),
            Answer::Stopped(memory) => {
                self.memory = memory;
                Reply::Ack
            }
            Answer::Full(report, first, memory) => {
                (self.memory, self.full) = (Some(memory), Some((report, first)));
                match verb {
                    CaptureVerb::Read(part) => self.read(part),
                    _ => Reply::Capture(report),
                }
            }
        };
        Some((sequence, reply))
    }

    fn is_possible(&self, arm: Arm) -> bool {
        usize::from(arm.before) <= SAMPLES && arm.lane < self.lanes
    }

    fn report(&self) -> CaptureReport {
        self.full.map_or(CaptureReport::default(), |(report, _)| report)
    }

    fn read(&self, part: u16) -> Reply {
        match (&self.memory, self.full) {
            (Some(_), Some(_)) if part >= PARTS => Reply::Nak(Refusal::OutOfRange),
            (Some(memory), Some((_, first))) => Reply::Captured(memory.part(first, part)),
            _ => Reply::Nak(Refusal::NotCaptured),
        }
    }
}
