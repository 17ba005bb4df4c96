//! Host's end of the link: sends commands and receives replies in the real frame format.

use embedded_io::Write;
use firmware::board::command::{Command, Reply};
use firmware::board::link::{self, Frame, FrameError, NO_SESSION, Receiver};
use firmware::seam::telemetry::Telemetry;

use crate::link::{End, LinkError};
use crate::noise::Noisy;

/// Host at the other end of the link.
#[derive(Debug)]
pub struct Host {
    /// Host's end of the link; its noise damages the host's frames.
    pub link: Noisy<End>,
    receiver: Receiver,
    sequence: u16,
    session: u32,
    frames: Vec<Frame<Reply>>,
    frame_errors: Vec<FrameError>,
}

impl Host {
    /// Creates a host at this end.
    pub fn new(end: End) -> Self {
        let (frames, frame_errors) = Default::default();
        Host { link: Noisy::new(end), receiver: Receiver::default(), sequence: 0, session: NO_SESSION, frames, frame_errors }
    }

    /// Returns the session that the board has given to this host, or [`NO_SESSION`] before an
    /// answer to [`Command::Identify`].
    pub fn session(&self) -> u32 {
        self.session
    }

    /// Sends a command in this host's session and returns the sequence number of its frame.
    pub fn send(&mut self, command: Command) -> Result<u16, LinkError> {
        self.sequence = self.sequence.wrapping_add(1);
        // Cannot fail: every command fits into a frame.
        let frame = link::encode(self.sequence, self.session, command).unwrap_or_default();
        self.link.write_all(&frame).map(|()| self.sequence)
    }

    /// Sends raw bytes.
    pub fn send_bytes(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.link.write_all(bytes)
    }

    /// Receives up to `bytes` from the board; `usize::MAX` receives all.
    pub fn receive(&mut self, bytes: usize) {
        for byte in self.link.inner.take(bytes) {
            match self.receiver.take(byte) {
                Some(Ok(frame)) => {
                    if let Reply::Identity(identity) = &frame.body {
                        self.session = identity.session;
                    }
                    self.frames.push(frame);
                }
                Some(Err(error)) => self.frame_errors.push(error),
                None => {}
            }
        }
    }

    /// Returns the frames received so far.
    pub fn frames(&self) -> &[Frame<Reply>] {
        &self.frames
    }

    /// Returns the telemetry received so far, with the sequence numbers of its frames.
    pub fn telemetry(&self) -> impl Iterator<Item = (u16, &Telemetry)> {
        self.frames.iter().filter_map(|frame| match &frame.body {
            Reply::Telemetry(telemetry) => Some((frame.sequence, telemetry)),
            _ => None,
        })
    }

    /// Returns the answers received so far, with the sequence numbers of the answered commands.
    pub fn answers(&self) -> impl Iterator<Item = (u16, &Reply)> {
        self.frames.iter().filter(|frame| !matches!(frame.body, Reply::Telemetry(_))).map(|frame| (frame.sequence, &frame.body))
    }

    /// Returns the latest answer to the command with this sequence number; numbers wrap.
    pub fn answer_to(&self, sequence: u16) -> Option<Reply> {
        self.answers().filter(|(answered, _)| *answered == sequence).last().map(|(_, reply)| *reply)
    }

    /// Returns the errors of the damaged frames.
    pub fn frame_errors(&self) -> &[FrameError] {
        &self.frame_errors
    }

    /// Deletes all received frames and errors.
    pub fn forget(&mut self) {
        self.frames.clear();
        self.frame_errors.clear();
    }
}
