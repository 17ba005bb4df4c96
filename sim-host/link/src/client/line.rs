//! Frames that come over a port, which is opened again where it is lost.

use std::collections::VecDeque;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use firmware::board::command::Reply;
use firmware::board::link::{Frame, FrameError, NO_SESSION, Receiver};
use firmware::seam::telemetry::Telemetry;

use crate::link_error::LinkError;
use crate::port::Port;
use crate::raw_frame::RawFrame;

/// Attempts to open a lost port again, and the pause before each.
const REOPENINGS: u32 = 10;
const REOPEN_PAUSE: Duration = Duration::from_millis(300);
/// Longest stretch without a look at Ctrl-C.
const SLICE: Duration = Duration::from_millis(50);
/// Most telemetry reports that are stored until the caller takes them.
const MOST_REPORTS: usize = 4096;

/// A port, and what has come over it.
pub(super) struct Line {
    pub(super) port: Box<dyn Port>,
    receiver: Receiver,
    pub(super) raw: RawFrame,
    /// Bytes that have come and have not been looked at.
    came: VecDeque<u8>,
    pub(super) telemetry: VecDeque<(u16, Telemetry)>,
    /// The session of this client; none before the board has given one.
    pub(super) session: u32,
    pub(super) counts: Counts,
    pub(super) stop: &'static AtomicBool,
    note: fn(&str),
}

/// How the link has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Commands sent, without copies.
    pub commands: u32,
    /// Copies of commands that were sent again.
    pub repeated: u32,
    /// Frames that came damaged.
    pub damaged: u32,
    /// Answers to what is not asked any more, and what is of another session.
    pub late: u32,
    /// Times that the port was opened again.
    pub reopened: u32,
}

/// What came.
pub(super) enum Came {
    Frame(Box<Frame<Reply>>),
    /// A report, which was put with the others.
    Telemetry,
    /// What was sent, or what came, was damaged on the way.
    Damage,
    /// A whole frame of another protocol version.
    Version(u8),
}

impl Line {
    /// Over this port.
    pub(super) fn new(port: Box<dyn Port>, stop: &'static AtomicBool, note: fn(&str)) -> Self {
        let (came, telemetry) = Default::default();
        Line {
            port,
            receiver: Receiver::default(),
            raw: RawFrame::default(),
            came,
            telemetry,
            session: NO_SESSION,
            counts: Counts::default(),
            stop,
            note,
        }
    }

    /// The next frame.
    pub(super) fn receive(&mut self, wait: Duration) -> Result<Option<Came>, LinkError> {
        let until = self.port.now() + wait;
        let mut version = None;
        loop {
            if self.stop.load(Ordering::Relaxed) {
                return Err(LinkError::Interrupted);
            }
            let now = self.port.now();
            if now >= until {
                return Ok(None);
            }
            let Some(byte) = self.came.pop_front() else {
                let mut bytes = [0; 256];
                match self.port.receive(&mut bytes, SLICE.min(until - now)) {
                    Ok(count) => self.came.extend(&bytes[..count]),
                    // Whoever holds it is not gone by trying again.
                    Err(error) if error.kind() == io::ErrorKind::ResourceBusy => {
                        return Err(LinkError::Open { port: self.port.name().to_owned(), why: error.to_string() });
                    }
                    Err(error) => {
                        self.reopen(&error.to_string())?;
                        return Ok(None);
                    }
                }
                continue;
            };
            version = self.raw.take(byte).or(version);
            match self.receiver.take::<Reply>(byte) {
                None => {}
                // What an earlier client has left unread, or what another one has asked for since.
                Some(Ok(Frame { session, body: Reply::Telemetry(_), .. }))
                    if self.session != NO_SESSION && session != self.session =>
                {
                    self.counts.late += 1;
                }
                Some(Ok(Frame { sequence, body: Reply::Telemetry(telemetry), .. })) => {
                    self.telemetry.drain(..(self.telemetry.len() + 1).saturating_sub(MOST_REPORTS));
                    self.telemetry.push_back((sequence, telemetry));
                    return Ok(Some(Came::Telemetry));
                }
                Some(Ok(frame)) => return Ok(Some(Came::Frame(Box::new(frame)))),
                Some(Err(FrameError::Version(_))) => return Ok(Some(Came::Version(version.unwrap_or(0)))),
                Some(Err(FrameError::TooLong | FrameError::Damaged)) => {
                    self.counts.damaged += 1;
                    return Ok(Some(Came::Damage));
                }
                Some(Err(FrameError::Unknown(..))) => {
                    self.counts.damaged += 1;
                    (self.note)("the board says something that this program does not know: is it newer?");
                    return Ok(Some(Came::Damage));
                }
            }
        }
    }

    /// Opens the port again, and goes on as if nothing had been: what was under way is asked for again.
    pub(super) fn reopen(&mut self, why: &str) -> Result<(), LinkError> {
        // A board in this process has stopped for good.
        if self.port.stands_still() {
            return Err(self.lost(why.to_owned()));
        }
        (self.note)(&format!("lost {}: {why}; trying to open it again", self.port.name()));
        let mut why = why.to_owned();
        for _ in 0..REOPENINGS {
            std::thread::sleep(REOPEN_PAUSE);
            if self.stop.load(Ordering::Relaxed) {
                return Err(LinkError::Interrupted);
            }
            match self.port.reopen() {
                Ok(()) => {
                    (self.note)(&format!("{} is back", self.port.name()));
                    self.receiver = Receiver::default();
                    self.came.clear();
                    self.counts.reopened += 1;
                    return Ok(());
                }
                Err(error) => why = error.to_string(),
            }
        }
        Err(self.lost(format!("{why} ({REOPENINGS} attempts)")))
    }

    /// Tells the user something.
    pub(super) fn say(&self, line: &str) {
        (self.note)(line);
    }

    /// It is gone.
    pub(super) fn lost(&self, why: String) -> LinkError {
        LinkError::Lost { port: self.port.name().to_owned(), why }
    }
}
