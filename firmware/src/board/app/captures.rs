//! Captures in the background task: requests to the recorder, and reading of the memory that it
//! hands over.

use heapless::spsc::{Consumer, Producer};

use crate::board::capture::memory::Memory;
use crate::board::capture::recorder::{CaptureReply, CaptureRequest};
use crate::board::capture::{Arm, CaptureReport, CaptureVerb, PARTS, SAMPLES};
use crate::board::command::Reply;
use crate::seam::refusal::Refusal;

/// State of the captures in the background task.
pub(super) struct Captures<'a> {
    requests: Producer<'a, CaptureRequest>,
    replies: Consumer<'a, CaptureReply>,
    lanes: u8,
    /// Memory, while the recorder does not own it.
    memory: Option<&'static mut Memory>,
    /// Report of the full capture, and the index of its first sample in the memory.
    full: Option<(CaptureReport, usize)>,
    /// Command that waits for an answer, with the number of its frame and its session.
    pending: Option<(u16, u32, CaptureVerb)>,
}

impl<'a> Captures<'a> {
    /// Creates captures with nothing recorded yet.
    pub(super) fn new(
        requests: Producer<'a, CaptureRequest>,
        replies: Consumer<'a, CaptureReply>,
        memory: &'static mut Memory,
        lanes: u8,
    ) -> Self {
        Captures { requests, replies, lanes, memory: Some(memory), full: None, pending: None }
    }

    /// Obeys a command; returns `None` if its answer comes with a later block.
    pub(super) fn obey(&mut self, sequence: u16, session: u32, verb: CaptureVerb) -> Option<Reply> {
        let here = self.memory.is_some();
        let wish = match verb {
            _ if self.pending.is_some() || !self.requests.ready() => return Some(Reply::Nak(Refusal::Busy)),
            CaptureVerb::Arm(arm) if !self.is_possible(arm) => return Some(Reply::Nak(Refusal::OutOfRange)),
            CaptureVerb::Arm(arm) => {
                self.full = None;
                CaptureRequest::Record(arm, self.memory.take())
            }
            CaptureVerb::State if here => return Some(Reply::Capture(self.report())),
            CaptureVerb::Read(part) if here => return Some(self.read(part)),
            CaptureVerb::Disarm if here => {
                self.full = None;
                return Some(Reply::Ack);
            }
            CaptureVerb::State | CaptureVerb::Read(_) => CaptureRequest::Look,
            CaptureVerb::Disarm => CaptureRequest::Stop,
        };
        self.pending = Some((sequence, session, verb));
        // There is room: the previous request was answered.
        let _ = self.requests.enqueue(wish);
        None
    }

    /// Returns the answer to an earlier command, with the number of its frame and its session, once
    /// the recorder has replied.
    pub(super) fn answer(&mut self) -> Option<(u16, u32, Reply)> {
        let answer = self.replies.dequeue()?;
        let (sequence, session, verb) = self.pending.take()?;
        let reply = match answer {
            CaptureReply::Records => Reply::Ack,
            CaptureReply::Not(report) if verb == CaptureVerb::State => Reply::Capture(report),
            CaptureReply::Not(_) => Reply::Nak(Refusal::NotCaptured),
            CaptureReply::Stopped(memory) => {
                self.memory = memory;
                Reply::Ack
            }
            CaptureReply::Full(report, first, memory) => {
                (self.memory, self.full) = (Some(memory), Some((report, first)));
                match verb {
                    CaptureVerb::Read(part) => self.read(part),
                    _ => Reply::Capture(report),
                }
            }
        };
        Some((sequence, session, reply))
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
