//! Output buffer to the host. Bytes that the link does not take now stay here; nothing waits for
//! it.

use embedded_io::{Write, WriteReady};
use heapless::Deque;

use crate::board::command::Reply;
use crate::board::link::{self, MAX_FRAME};

/// Size of the buffer, bytes: a reply always fits next to one telemetry frame.
const CAPACITY_BYTES: usize = 2 * MAX_FRAME;

/// Bytes to be sent.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    bytes: Deque<u8, CAPACITY_BYTES>,
}

impl Outbox {
    /// Returns `true` if any frame would fit.
    pub(super) fn has_room(&self) -> bool {
        self.bytes.len() + MAX_FRAME <= CAPACITY_BYTES
    }

    /// Returns `true` if the link has taken all bytes.
    pub(super) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Adds a frame, for which there is room.
    pub(super) fn send(&mut self, sequence: u16, session: u32, reply: Reply) {
        // The largest reply fits into a frame; the tests of the link check this.
        if let Ok(frame) = link::encode(sequence, session, reply) {
            self.bytes.extend(frame);
        }
    }

    /// Writes as many bytes as the link takes now, one at a time: a longer write may wait for its
    /// last byte.
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
