//! What is on its way to the host. Nothing waits for the link: what it does not take now stays here.

use embedded_io::{Write, WriteReady};
use heapless::Deque;

use crate::board::command::Reply;
use crate::board::link::{self, MAX_FRAME};

/// Room for what is to be sent: a reply always fits beside one telemetry frame.
const ROOM: usize = 2 * MAX_FRAME;

/// Bytes that are to be sent.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    bytes: Deque<u8, ROOM>,
}

impl Outbox {
    /// Whether any frame would fit.
    pub(super) fn has_room(&self) -> bool {
        self.bytes.len() + MAX_FRAME <= ROOM
    }

    /// Whether everything has been taken by the link.
    pub(super) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Puts in a frame, for which there is room.
    pub(super) fn send(&mut self, sequence: u16, session: u32, reply: Reply) {
        // The largest reply fits into a frame: tested with the link.
        if let Ok(frame) = link::encode(sequence, session, reply) {
            self.bytes.extend(frame);
        }
    }

    /// Gives the link as much as it takes now. Byte by byte: a write of more may wait for the last of them.
    pub(super) fn flush<L: Write + WriteReady>(&mut self, link: &mut L) -> Result<(), L::Error> {
        while let Some(&byte) = self.bytes.front() {
            if !link.write_ready()? || link.write(&[byte])? == 0 {
                break;
            }
            self.bytes.pop_front();
        }
        Ok(())
    }
}
