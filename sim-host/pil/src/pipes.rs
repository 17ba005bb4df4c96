//! Exchange of records with QEMU: one request, one reply.

use std::io::{self, PipeReader, PipeWriter, Read, Write};
use std::path::Path;

use firmware::board::lockstep::{self, Closing, Record};

use super::emulator::{Emulator, Serial};
use sim::processor::Lost;

/// Both pipes, and QEMU.
pub struct Pipes {
    to: PipeWriter,
    from: PipeReader,
    buffer: lockstep::Buffer,
    emulator: Emulator,
}

impl Pipes {
    /// Starts QEMU on an image.
    pub fn start(image: &Path, serial: Serial) -> io::Result<Self> {
        let (emulator, to, from) = Emulator::start(image, serial)?;
        Ok(Pipes { to, from, buffer: lockstep::BUFFER, emulator })
    }

    /// Returns the running QEMU process.
    pub fn emulator(&self) -> &Emulator {
        &self.emulator
    }

    /// Sends a record and waits for its answer.
    pub fn ask(&mut self, question: &impl Record, answer: &mut impl Record) -> Result<(), Lost> {
        self.exchange(|buffer| lockstep::encode(question, buffer).ok(), answer)
    }

    /// Requests the memory that the run has used so far.
    pub fn close(&mut self) -> Result<Closing, Lost> {
        let mut closing = Closing::default();
        self.exchange(|_| Some(&lockstep::CLOSE), &mut closing)?;
        Ok(closing)
    }

    fn exchange(
        &mut self,
        record: impl FnOnce(&mut lockstep::Buffer) -> Option<&[u8]>,
        answer: &mut impl Record,
    ) -> Result<(), Lost> {
        let bytes = record(&mut self.buffer).ok_or_else(|| Lost("a record is too long".into()))?;
        self.emulator.turn();
        let body = match self.to.write_all(bytes) {
            Ok(()) => lockstep::receive(&mut self.buffer, |bytes| self.from.read(bytes)),
            Err(error) => Err(error),
        };
        self.emulator.turn();
        match body {
            Ok(Some(body)) => lockstep::decode(body, answer)
                .map_err(|_| Lost("its answer cannot be decoded: the image was built from another source".into())),
            Ok(None) | Err(_) => Err(Lost(self.emulator.describe_end())),
        }
    }
}
