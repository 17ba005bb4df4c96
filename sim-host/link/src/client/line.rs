//! Reception of frames over a port, which is reopened if it is lost.

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

/// Number of attempts to reopen a lost port.
const REOPEN_ATTEMPTS: u32 = 10;
/// Pause before each attempt.
const REOPEN_PAUSE: Duration = Duration::from_millis(300);
/// Longest wait without a check for Ctrl-C.
const STOP_CHECK_INTERVAL: Duration = Duration::from_millis(50);
/// Maximum number of telemetry reports stored until the caller reads them.
const MAX_REPORTS: usize = 4096;

/// Port with its received bytes and reports.
pub(super) struct Line {
    pub(super) port: Box<dyn Port>,
    receiver: Receiver,
    pub(super) raw: RawFrame,
    /// Received bytes that have not been processed.
    unread: VecDeque<u8>,
    pub(super) telemetry: VecDeque<(u16, Telemetry)>,
    /// Session of this client; `NO_SESSION` before the board has granted one.
    pub(super) session: u32,
    pub(super) counts: Counts,
    pub(super) stop: &'static AtomicBool,
    note: fn(&str),
}

/// Counts of commands and errors of a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Commands sent, without copies.
    pub commands: u32,
    /// Repeated copies of commands.
    pub repeated: u32,
    /// Frames that arrived damaged.
    pub damaged: u32,
    /// Answers to earlier requests, and frames of another session.
    pub late: u32,
    /// Times that the port was reopened.
    pub reopened: u32,
}

/// Event of a reception.
pub(super) enum Received {
    Frame(Box<Frame<Reply>>),
    /// A telemetry report, which was queued.
    Telemetry,
    /// A damaged frame, in either direction.
    Damage,
    /// An intact frame of another protocol version.
    Version(u8),
}

impl Line {
    /// Creates a line over this port.
    pub(super) fn new(port: Box<dyn Port>, stop: &'static AtomicBool, note: fn(&str)) -> Self {
        let (unread, telemetry) = Default::default();
        Line {
            port,
            receiver: Receiver::default(),
            raw: RawFrame::default(),
            unread,
            telemetry,
            session: NO_SESSION,
            counts: Counts::default(),
            stop,
            note,
        }
    }

    /// Waits for the next frame.
    pub(super) fn receive(&mut self, wait: Duration) -> Result<Option<Received>, LinkError> {
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
            let Some(byte) = self.unread.pop_front() else {
                let mut bytes = [0; 256];
                match self.port.receive(&mut bytes, STOP_CHECK_INTERVAL.min(until - now)) {
                    Ok(count) => self.unread.extend(&bytes[..count]),
                    // Another attempt does not help while another program holds the port.
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
                // A frame that an earlier client has not read, or that another client has
                // requested.
                Some(Ok(Frame { session, body: Reply::Telemetry(_), .. }))
                    if self.session != NO_SESSION && session != self.session =>
                {
                    self.counts.late += 1;
                }
                Some(Ok(Frame { sequence, body: Reply::Telemetry(telemetry), .. })) => {
                    self.telemetry.drain(..(self.telemetry.len() + 1).saturating_sub(MAX_REPORTS));
                    self.telemetry.push_back((sequence, telemetry));
                    return Ok(Some(Received::Telemetry));
                }
                Some(Ok(frame)) => return Ok(Some(Received::Frame(Box::new(frame)))),
                Some(Err(FrameError::Version(_))) => return Ok(Some(Received::Version(version.unwrap_or(0)))),
                Some(Err(FrameError::TooLong | FrameError::Damaged)) => {
                    self.counts.damaged += 1;
                    return Ok(Some(Received::Damage));
                }
                Some(Err(FrameError::Unknown(..))) => {
                    self.counts.damaged += 1;
                    (self.note)("the board has sent a message that this program does not know: is its firmware newer?");
                    return Ok(Some(Received::Damage));
                }
            }
        }
    }

    /// Reopens the port. The caller repeats the request that was pending.
    pub(super) fn reopen(&mut self, why: &str) -> Result<(), LinkError> {
        if !self.port.can_reopen() {
            return Err(self.lost(why.to_owned()));
        }
        (self.note)(&format!("lost {}: {why}; trying to open it again", self.port.name()));
        let mut why = why.to_owned();
        for _ in 0..REOPEN_ATTEMPTS {
            std::thread::sleep(REOPEN_PAUSE);
            if self.stop.load(Ordering::Relaxed) {
                return Err(LinkError::Interrupted);
            }
            match self.port.reopen() {
                Ok(()) => {
                    (self.note)(&format!("{} is back", self.port.name()));
                    self.receiver = Receiver::default();
                    self.unread.clear();
                    self.counts.reopened += 1;
                    return Ok(());
                }
                Err(error) => why = error.to_string(),
            }
        }
        Err(self.lost(format!("{why} ({REOPEN_ATTEMPTS} attempts)")))
    }

    /// Passes a message to the user.
    pub(super) fn say(&self, line: &str) {
        (self.note)(line);
    }

    /// Returns the error for a lost port.
    pub(super) fn lost(&self, why: String) -> LinkError {
        LinkError::Lost { port: self.port.name().to_owned(), why }
    }
}
