//! The controller under QEMU, as a processor.

use std::io::{PipeReader, PipeWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use firmware::block::{DriveBlock, Orders, SenseBlock};
use firmware::config::Config;
use firmware::lockstep::{self, Answer, Closing, Opening, Question};
use firmware::telemetry::Telemetry;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::PilError;
use super::emulator::Emulator;
use super::one_core::OneCore;
use super::size::Size;
use crate::processor::{Lost, Memory, Processor};

/// The controller as thumb code under QEMU.
///
/// While it lives, the thread that started it is pinned to one core with QEMU; it cannot move to another thread.
pub struct Qemu {
    pipes: Pipes,
    image: PathBuf,
    silence: DriveBlock,
    question: Question,
    /// What the latest block has taken.
    instructions: Option<u32>,
    _core: OneCore,
}

impl Qemu {
    /// Starts an [image](fn@super::image) and builds its controller.
    pub fn start(image: &Path, config: &Config) -> Result<Self, PilError> {
        // Before the pipes' process is started, which inherits it.
        let core = OneCore::pin();
        let (emulator, to, from) = Emulator::start(image)?;
        let mut pipes = Pipes { to, from, buffer: lockstep::BUFFER, emulator };
        match pipes.ask::<_, Opening>(config)? {
            Ok(silence) => Ok(Qemu {
                pipes,
                image: image.to_owned(),
                silence: silence.drive,
                question: Question::default(),
                instructions: None,
                _core: core,
            }),
            Err(reason) => Err(PilError::Config(reason.as_str().to_owned())),
        }
    }

    /// Sets how long QEMU may take for an answer; 30 s unless told. Longer is for a debugger on the guest.
    pub fn set_patience(&mut self, patience: Duration) {
        self.pipes.emulator.set_patience(patience);
    }

    /// QEMU's process.
    pub fn process_id(&self) -> u32 {
        self.pipes.emulator.process_id()
    }
}

impl Processor for Qemu {
    fn silence(&self) -> DriveBlock {
        self.silence.clone()
    }

    fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost> {
        self.question.orders = *orders;
        self.question.sense.clone_from(sense);
        let answer: Answer = self.pipes.ask(&self.question)?;
        *drive = answer.drive;
        self.instructions = answer.instructions;
        Ok(answer.telemetry)
    }

    fn instructions(&self) -> Option<u32> {
        self.instructions
    }

    fn memory(&mut self) -> Result<Option<Memory>, Lost> {
        let Closing { stack_power_up_bytes, stack_blocks_bytes } = self.pipes.exchange(|_| Some(&lockstep::CLOSE))?;
        let Size { flash, ram } =
            Size::of(&self.image).map_err(|error| Lost(format!("its image {} cannot be read: {error}", self.image.display())))?;
        Ok(Some(Memory { stack_power_up: stack_power_up_bytes, stack_blocks: stack_blocks_bytes, flash, ram }))
    }
}

/// The way to QEMU and back.
struct Pipes {
    to: PipeWriter,
    from: PipeReader,
    buffer: lockstep::Buffer,
    emulator: Emulator,
}

impl Pipes {
    /// Sends a record and waits for the one that answers it.
    fn ask<Q: Serialize, A: DeserializeOwned>(&mut self, question: &Q) -> Result<A, Lost> {
        self.exchange(|buffer| lockstep::encode(question, buffer).ok())
    }

    /// The same with a record as it is.
    fn exchange<A: DeserializeOwned>(&mut self, record: impl FnOnce(&mut lockstep::Buffer) -> Option<&[u8]>) -> Result<A, Lost> {
        let bytes = record(&mut self.buffer).ok_or_else(|| Lost("a question is too long".into()))?;
        self.emulator.turn();
        let answer = match self.to.write_all(bytes) {
            Ok(()) => lockstep::receive(&mut self.buffer, |bytes| self.from.read(bytes)),
            Err(error) => Err(error),
        };
        self.emulator.turn();
        match answer {
            Ok(Some(body)) => {
                lockstep::decode(body).map_err(|_| Lost("its answer cannot be read: the image is not of this source".into()))
            }
            Ok(None) | Err(_) => Err(Lost(self.emulator.obituary())),
        }
    }
}
