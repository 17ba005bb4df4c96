//! Where the controller runs: here, or as thumb code in an emulator. The rest of a run does not know which.

use firmware::controller::Controller;
use firmware::seam::block::{DriveBlock, Orders, SenseBlock};
use firmware::seam::config::Config;
use firmware::seam::telemetry::Telemetry;

/// Something that runs the controller, one block a call.
pub trait Processor {
    /// A block of silence, which plays until the first call has returned.
    fn silence(&self) -> DriveBlock;

    /// One block. Fails only where the controller runs elsewhere and is lost.
    fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost>;

    /// The same, with the report in the place of an earlier one.
    fn process_into(
        &mut self,
        orders: &Orders,
        sense: &SenseBlock,
        drive: &mut DriveBlock,
        report: &mut Telemetry,
    ) -> Result<(), Lost> {
        *report = self.process(orders, sense, drive)?;
        Ok(())
    }

    /// The sample of the block after the latest one from which a [dropped](DriveBlock::drops_queue) queue was silent, where that was measured.
    fn silent_from(&self) -> Option<usize> {
        None
    }

    /// Instructions that the latest block has taken, where they are counted.
    fn instructions(&self) -> Option<u32> {
        None
    }

    /// Cycles that the latest block has taken of the processor, with what surrounds the controller there, where they are counted.
    fn cycles(&self) -> Option<u32> {
        None
    }

    /// What the processor's time has gone to, where its part is modelled.
    fn load(&self) -> Option<Load> {
        None
    }

    /// What the controller has needed of its memory so far, where that is measured.
    fn memory(&mut self) -> Result<Option<Memory>, Lost> {
        Ok(None)
    }
}

/// What the time of a part went to that runs the block interrupt and a background task.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Load {
    /// Cycles of a block.
    pub block_cycles: u32,
    /// Of the block interrupt's instruction fetches those from flash, 0 to 1.
    pub flash_fetches: f64,
    /// The longest time with interrupts masked, cycles.
    pub longest_masked: u32,
    /// What each function took of the block interrupts, the most cycles first; empty where it was not asked for.
    pub functions: Vec<InFunction>,
}

/// What a function took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InFunction {
    /// Its name.
    pub name: String,
    /// Instructions executed in it.
    pub instructions: u64,
    /// Cycles of them.
    pub cycles: u64,
    /// Fetches of them from flash, of 8 bytes each.
    pub flash_fetches: u64,
}

/// What a controller on a processor of its own needs of its memory, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// The deepest that the stack was until the controller was built.
    pub stack_power_up: u32,
    /// The deepest that it was in the blocks.
    pub stack_blocks: u32,
    /// Flash: code, constants, and what the static variables begin with.
    pub flash: u64,
    /// Static variables, the controller among them.
    pub ram: u64,
}

/// The processor is gone.
#[derive(Debug, thiserror::Error)]
#[error("the processor that runs the controller is lost: {0}")]
pub struct Lost(pub String);

/// The controller in this process.
pub struct Here(Controller);

impl Here {
    /// Builds the controller; the error names the parameter that is out of range.
    pub fn new(config: &Config) -> Result<Self, firmware::seam::error::Error> {
        Controller::build(config).map(Here)
    }
}

impl Processor for Here {
    fn silence(&self) -> DriveBlock {
        self.0.silence()
    }

    fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost> {
        Ok(self.0.process(orders, sense, drive))
    }

    fn process_into(
        &mut self,
        orders: &Orders,
        sense: &SenseBlock,
        drive: &mut DriveBlock,
        report: &mut Telemetry,
    ) -> Result<(), Lost> {
        self.0.process_into(orders, sense, drive, report);
        Ok(())
    }
}
