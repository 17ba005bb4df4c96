//! A drive that is stopped and ordered again: `lock, stop, lock` of the command line, without a pause that would let the transducer ring down.

use firmware::seam::block::{DriveBlock, Orders, Request, SenseBlock};
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use sim::processor::{Here, Lost, Processor};

/// Blocks of the first run, from its lock on, before it is stopped.
const RUN_BLOCKS: u32 = 1500;
/// Blocks of silence before it is ordered again: 1 ms, as two commands that follow one another.
const SILENT_BLOCKS: u32 = 32;

/// The controller in this process, whose run is stopped once and ordered again.
pub struct Restarted {
    controller: Here,
    running: u32,
    silent: u32,
}

impl Restarted {
    /// A controller that has not run yet.
    pub fn new(controller: Here) -> Self {
        Restarted { controller, running: 0, silent: 0 }
    }
}

impl Processor for Restarted {
    fn silence(&self) -> DriveBlock {
        self.controller.silence()
    }

    fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost> {
        let stopped = self.running >= RUN_BLOCKS;
        self.silent += u32::from(stopped && self.silent < SILENT_BLOCKS);
        let again = u32::from(stopped && self.silent == SILENT_BLOCKS);
        let request = if stopped && again == 0 { Request::Idle } else { orders.request };
        let sequence = orders.sequence + u32::from(stopped) + again;
        let orders = Orders { sequence, attempt: orders.attempt + again, request, ..*orders };
        let telemetry = self.controller.process(&orders, sense, drive)?;
        self.running += u32::from(telemetry.mode == Mode::Run);
        Ok(telemetry)
    }
}
