//! The image of the emulator on the processor of the crate `cortex-m4`, in this process.
//!
//! It models the machine that QEMU emulates for the image: flash, RAM, and files by semihosting.
//! Each instruction takes a nanosecond, as with `-icount shift=0` of QEMU. SysTick counts at 168
//! MHz, so that the image counts the same number of instructions on both.

use std::io::Read as _;
use std::path::Path;

use columns::file;
use cortex_m4::{Cycle, Machine, Memory, Region, Timing};
use firmware::board::lockstep::{self, Answer, Closing, Opening, Question, Record};
use firmware::seam::block::{DriveBlock, Orders, SenseBlock};
use firmware::seam::config::Config;
use firmware::seam::telemetry::Telemetry;
use sim::processor::{self, Lost, Processor};

use pil::PilError;
use pil::size::Size;

use crate::semihosting::{Host, Waits};

/// Flash of the STM32F405, bytes.
const FLASH: usize = 1 << 20;
/// RAM of the STM32F405, bytes.
const RAM: usize = 128 << 10;
/// Implemented bits of an interrupt priority of the STM32F405.
const PRIORITY_BITS: u8 = 4;
/// Number of SysTick counts in `SYSTICK_NS`, at 168 MHz.
const SYSTICK_COUNTS: u32 = 21;
/// Duration of `SYSTICK_COUNTS` counts, ns.
const SYSTICK_NS: u32 = 125;
/// Maximum number of instructions for an answer.
const MAX_INSTRUCTIONS: Cycle = 1_000_000_000;

/// Machine with a buffer for a record.
struct Guest {
    machine: Machine<Host>,
    buffer: lockstep::Buffer,
}

impl Guest {
    /// Sends a record, runs until the image waits for the next one, and decodes its answer.
    fn ask(&mut self, record: impl FnOnce(&mut lockstep::Buffer) -> Option<&[u8]>, answer: &mut impl Record) -> Result<(), Lost> {
        let bytes = record(&mut self.buffer).ok_or_else(|| Lost("the record is too long".into()))?;
        self.machine.chip.from_host.extend_from_slice(bytes);
        match self.machine.run_until(self.machine.cycle() + MAX_INSTRUCTIONS) {
            Err(stop) if stop.finding.is::<Waits>() => {}
            Err(stop) => return Err(Lost(stop.to_string())),
            Ok(_) => return Err(Lost("the image does not answer".into())),
        }
        let sent = std::mem::take(&mut self.machine.chip.to_host);
        match lockstep::receive(&mut self.buffer, |room| sent.as_slice().read(room)) {
            Ok(Some(body)) => lockstep::decode(body, answer)
                .map_err(|_| Lost("the answer cannot be decoded: the image is from another version of the source".into())),
            Ok(None) | Err(_) => Err(Lost("the image does not answer".into())),
        }
    }
}

/// Controller as Thumb code on the interpreter.
pub struct Interpreter {
    guest: Guest,
    size: Size,
    silence: DriveBlock,
    question: Question,
    answer: Answer,
}

impl Interpreter {
    /// Starts an [image](fn@pil::image) and builds its controller.
    pub fn start(image: &Path, config: &Config) -> Result<Self, PilError> {
        let elf = file::read(image, file::MAX_DATA_BYTES)?;
        let size = Size::of(&elf).map_err(|error| Lost(format!("the image cannot be read: {error}")))?;
        let mut memory = Memory::default();
        memory.add(Region { base: 0x0800_0000, bytes: vec![0xff; FLASH], writable: false, waits: false });
        memory.add(Region { base: 0x2000_0000, bytes: vec![0; RAM], writable: true, waits: false });
        let machine = Machine::new(&elf, memory, Host::default(), PRIORITY_BITS);
        let mut machine = machine.map_err(|error| Lost(format!("the image cannot be loaded: {error}")))?;
        machine.set_timing(Timing::Instructions);
        machine.set_systick_clock(SYSTICK_COUNTS, SYSTICK_NS);
        let mut guest = Guest { machine, buffer: lockstep::BUFFER };
        let mut opening = Opening::default();
        guest.ask(|buffer| lockstep::encode(config, buffer).ok(), &mut opening)?;
        match opening.built {
            Ok(()) => Ok(Interpreter {
                guest,
                size,
                silence: opening.silence,
                question: Question::default(),
                answer: Answer::default(),
            }),
            Err(reason) => Err(PilError::Config(reason.as_str().to_owned())),
        }
    }
}

impl Processor for Interpreter {
    fn silence(&self) -> DriveBlock {
        self.silence.clone()
    }

    fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost> {
        self.question.orders = *orders;
        self.question.sense.clone_from(sense);
        self.guest.ask(|buffer| lockstep::encode(&self.question, buffer).ok(), &mut self.answer)?;
        drive.clone_from(&self.answer.drive);
        Ok(self.answer.telemetry)
    }

    fn instructions(&self) -> Option<u32> {
        self.answer.instructions
    }

    fn memory(&mut self) -> Result<Option<processor::Memory>, Lost> {
        let mut closing = Closing::default();
        self.guest.ask(|_| Some(&lockstep::CLOSE), &mut closing)?;
        let Closing { stack_power_up_bytes: stack_power_up, stack_blocks_bytes: stack_blocks } = closing;
        let Size { flash, ram } = self.size;
        Ok(Some(processor::Memory { stack_power_up, stack_blocks, flash, ram }))
    }
}
