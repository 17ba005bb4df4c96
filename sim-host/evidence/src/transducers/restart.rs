//! A drive that is stopped and restarted: `lock, stop, lock` of the command line, without a pause
//! in which the transducer could ring down.

use firmware::seam::block::{DriveBlock, Orders, Request, SenseBlock};
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use sim::processor::{Here, Lost, Processor};

/// Number of blocks from the lock of the first run to its stop.
const RUN_BLOCKS: u32 = 1500;
/// Number of silent blocks before the restart: 1 ms, as between two successive commands.
const SILENT_BLOCKS: u32 = 32;

/// Controller in this process, whose run is stopped once and restarted.
pub struct Restarted {
    controller: Here,
    running: u32,
    silent: u32,
}

impl Restarted {
    /// Wraps a controller that has not run yet.
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
