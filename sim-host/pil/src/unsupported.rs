//! No processor in the loop on this system.

use std::convert::Infallible;
use std::path::Path;
use std::time::Duration;

use firmware::seam::block::{DriveBlock, Orders, SenseBlock};
use firmware::seam::config::Config;
use firmware::seam::telemetry::Telemetry;

use super::{PilError, missing};
use sim::processor::{Lost, Processor};

/// The controller as thumb code under QEMU; not available on this system.
pub struct Qemu(Infallible);

impl Qemu {
    /// Fails with the reason.
    pub fn start(_image: &Path, _config: &Config) -> Result<Self, PilError> {
        Err(PilError::Missing(missing().unwrap_or_default()))
    }

    /// Has no effect.
    pub fn set_patience(&mut self, _patience: Duration) {
        match self.0 {}
    }

    /// Never returns, as there is no process.
    pub fn process_id(&self) -> u32 {
        match self.0 {}
    }
}

impl Processor for Qemu {
    fn silence(&self) -> DriveBlock {
        match self.0 {}
    }

    fn process(&mut self, _: &Orders, _: &SenseBlock, _: &mut DriveBlock) -> Result<Telemetry, Lost> {
        match self.0 {}
    }
}
