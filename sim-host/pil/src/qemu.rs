//! The controller under QEMU, as a processor.

use std::path::{Path, PathBuf};
use std::time::Duration;

use firmware::board::lockstep::{Answer, Closing, Opening, Question};
use firmware::seam::block::{DriveBlock, Orders, SenseBlock};
use firmware::seam::config::Config;
use firmware::seam::telemetry::Telemetry;

use super::PilError;
use super::cpu_affinity::CpuAffinity;
use super::emulator::Serial;
use super::pipes::Pipes;
use super::size::Size;
use columns::file;
use sim::processor::{Lost, Memory, Processor};

/// The controller as thumb code under QEMU.
///
/// While it exists, the thread that started it is pinned to one core with QEMU; it cannot move to
/// another thread.
pub struct Qemu {
    pipes: Pipes,
    image: PathBuf,
    silence: DriveBlock,
    question: Question,
    answer: Answer,
    _core: CpuAffinity,
}

impl Qemu {
    /// Starts an [image](fn@super::image) and builds its controller.
    pub fn start(image: &Path, config: &Config) -> Result<Self, PilError> {
        // Pinned before QEMU is started, which inherits it.
        let core = CpuAffinity::pin();
        let mut pipes = Pipes::start(image, Serial::None)?;
        let mut opening = Opening::default();
        pipes.ask(config, &mut opening)?;
        match opening.built {
            Ok(()) => Ok(Qemu {
                pipes,
                image: image.to_owned(),
                silence: opening.silence,
                question: Question::default(),
                answer: Answer::default(),
                _core: core,
            }),
            Err(reason) => Err(PilError::Config(reason.as_str().to_owned())),
        }
    }

    /// Sets the time limit for answers of QEMU; 30 s by default. A longer limit is for a debugger
    /// on the guest.
    pub fn set_patience(&mut self, patience: Duration) {
        self.pipes.emulator().set_patience(patience);
    }

    /// Returns the process id of QEMU.
    pub fn process_id(&self) -> u32 {
        self.pipes.emulator().process_id()
    }
}

impl Processor for Qemu {
    fn silence(&self) -> DriveBlock {
        self.silence.clone()
    }

    fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost> {
        self.question.orders = *orders;
        self.question.sense.clone_from(sense);
        self.pipes.ask(&self.question, &mut self.answer)?;
        drive.clone_from(&self.answer.drive);
        Ok(self.answer.telemetry)
    }

    fn instructions(&self) -> Option<u32> {
        self.answer.instructions
    }

    fn memory(&mut self) -> Result<Option<Memory>, Lost> {
        let closing = self.pipes.close()?;
        let unreadable =
            |error: &dyn std::error::Error| Lost(format!("the image {} cannot be read: {error}", self.image.display()));
        let elf = file::read(&self.image, file::MAX_DATA_BYTES).map_err(|error| unreadable(&error))?;
        let Size { flash, ram } = Size::of(&elf).map_err(|error| unreadable(&error))?;
        let Closing { stack_power_up_bytes: stack_power_up, stack_blocks_bytes: stack_blocks } = closing;
        Ok(Some(Memory { stack_power_up, stack_blocks, flash, ram }))
    }
}
