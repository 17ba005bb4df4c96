//! The host's end of the link: commands out and replies in, by the real frame format.

use embedded_io::Write;
use firmware::board::command::{Command, Reply};
use firmware::board::link::{self, Frame, FrameError, NO_SESSION, Receiver};
use firmware::seam::telemetry::Telemetry;

use crate::link::{End, LinkError};
use crate::noise::Noisy;

/// A host at the other end of the link.
#[derive(Debug)]
pub struct Host {
    /// The host's end; its noise damages what the host sends.
    pub link: Noisy<End>,
    receiver: Receiver,
    sequence: u16,
    session: u32,
    frames: Vec<Frame<Reply>>,
    spoiled: Vec<FrameError>,
}

impl Host {
    /// A host at this end.
    pub fn new(end: End) -> Self {
        let (frames, spoiled) = Default::default();
        Host { link: Noisy::new(end), receiver: Receiver::default(), sequence: 0, session: NO_SESSION, frames, spoiled }
    }

    /// The session that the board has given this host; [`NO_SESSION`] before the board has answered [`Command::Identify`].
    pub fn session(&self) -> u32 {
        self.session
    }

    /// Sends a command of this host's session and returns its frame's sequence number.
    pub fn send(&mut self, command: Command) -> Result<u16, LinkError> {
        self.sequence = self.sequence.wrapping_add(1);
        // Every command fits into a frame.
        let frame = link::encode(self.sequence, self.session, command).unwrap_or_default();
        self.link.write_all(&frame).map(|()| self.sequence)
    }

    /// Sends bytes as they are.
    pub fn send_bytes(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.link.write_all(bytes)
    }

    /// Takes up to `bytes` of what the board has sent; `usize::MAX` takes all.
    pub fn receive(&mut self, bytes: usize) {
        for byte in self.link.inner.take(bytes) {
            match self.receiver.take(byte) {
                Some(Ok(frame)) => {
                    if let Reply::Identity(identity) = &frame.body {
                        self.session = identity.session;
                    }
                    self.frames.push(frame);
                }
                Some(Err(error)) => self.spoiled.push(error),
                None => {}
            }
        }
    }

    /// The frames received so far.
    pub fn frames(&self) -> &[Frame<Reply>] {
        &self.frames
    }

    /// The telemetry received so far, with its frames' sequence numbers.
    pub fn telemetry(&self) -> impl Iterator<Item = (u16, &Telemetry)> {
        self.frames.iter().filter_map(|frame| match &frame.body {
            Reply::Telemetry(telemetry) => Some((frame.sequence, telemetry)),
            _ => None,
        })
    }

    /// The answers received so far, with the sequence numbers of what they answer.
    pub fn answers(&self) -> impl Iterator<Item = (u16, &Reply)> {
        self.frames.iter().filter(|frame| !matches!(frame.body, Reply::Telemetry(_))).map(|frame| (frame.sequence, &frame.body))
    }

    /// The answer to the command with this sequence number; the latest, because numbers come round.
    pub fn answer_to(&self, sequence: u16) -> Option<Reply> {
        self.answers().filter(|(answered, _)| *answered == sequence).last().map(|(_, reply)| *reply)
    }

    /// Errors of the frames that were received damaged.
    pub fn spoiled(&self) -> &[FrameError] {
        &self.spoiled
    }

    /// Forgets what was received so far.
    pub fn forget(&mut self) {
        self.frames.clear();
        self.spoiled.clear();
    }
}
