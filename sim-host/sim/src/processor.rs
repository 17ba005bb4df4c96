//! Processor of the controller: this process, or an emulator of thumb code. The rest of a run is
//! independent of it.

use firmware::controller::Controller;
use firmware::seam::block::{DriveBlock, Orders, SenseBlock};
use firmware::seam::config::Config;
use firmware::seam::telemetry::Telemetry;

/// Processor that runs the controller, one block per call.
pub trait Processor {
    /// Returns a block of silence, which plays until the first call has returned.
    fn silence(&self) -> DriveBlock;

    /// Processes one block. Fails only if the controller runs in another process that is lost.
    fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost>;

    /// Processes one block and overwrites the report.
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

    /// Returns the sample of the block after the latest one from which a
    /// [dropped](DriveBlock::drops_queue) queue was silent, if measured.
    fn silent_from(&self) -> Option<usize> {
        None
    }

    /// Returns the instructions of the latest block, if counted.
    fn instructions(&self) -> Option<u32> {
        None
    }

    /// Returns the processor cycles of the latest block, including the code around the controller,
    /// if counted.
    fn cycles(&self) -> Option<u32> {
        None
    }

    /// Returns the load of the processor, if its part is modelled.
    fn load(&self) -> Option<Load> {
        None
    }

    /// Returns the memory that the controller has used so far, if measured.
    fn memory(&mut self) -> Result<Option<Memory>, Lost> {
        Ok(None)
    }
}

/// Load of a part that runs the block interrupt and a background task.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Load {
    /// Duration of a block, cycles.
    pub block_cycles: u32,
    /// Fraction of the block interrupt's instruction fetches that are from flash, 0 to 1.
    pub flash_fetches: f64,
    /// Longest time with interrupts masked, cycles.
    pub longest_masked: u32,
    /// Share of each function in the block interrupts, those with the most cycles in the longest
    /// block first; empty if not requested.
    pub functions: Vec<InFunction>,
}

/// Share of a function.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InFunction {
    /// Name of the function.
    pub name: String,
    /// Number of instructions executed in the function.
    pub instructions: u64,
    /// Cycles of these instructions.
    pub cycles: u64,
    /// Number of fetches of these instructions from flash, of 8 bytes each.
    pub flash_fetches: u64,
    /// Instructions and cycles of these in the block with the most cycles.
    pub longest_instructions: u64,
    /// See `longest_instructions`.
    pub longest_cycles: u64,
}

/// Memory of a controller on its own processor, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Maximum stack depth until the controller was built.
    pub stack_power_up: u32,
    /// Maximum stack depth in the blocks.
    pub stack_blocks: u32,
    /// Flash: code, constants, and initial values of the static variables.
    pub flash: u64,
    /// Static variables, including the controller.
    pub ram: u64,
}

/// Error of a lost processor.
#[derive(Debug, thiserror::Error)]
#[error("the processor that runs the controller is lost: {0}")]
pub struct Lost(pub String);

/// Controller in this process.
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
