//! A build without the model of the microcontroller: every use names the command that has it.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::link::LinkArgs;
use super::{Color, Exit, mistake, without};
use link::link_error::LinkError;
use scene::Driven;
use sim::processor::Processor;
use sim::run::RunError;

const MODEL: &str = "model of the microcontroller (`--board`, `board:SCENE`)";

/// Returns no values.
pub(super) fn defaults() -> Vec<String> {
    Vec::new()
}

/// The flashed image, which this build cannot run.
pub(super) enum Flashed {}

impl Flashed {
    /// Refuses.
    pub(super) fn new(_: Option<&Path>, _: &Driven, _: Option<f64>, _: bool) -> anyhow::Result<Self> {
        Err(mistake(Exit::Usage, without(MODEL)))
    }

    /// Cannot be called.
    pub(super) fn start(&self, _: &Driven, _: &'static AtomicBool) -> Result<Box<dyn Processor>, RunError> {
        match *self {}
    }
}

/// Refuses.
pub(super) fn talk(_: &LinkArgs, _: &Driven, _: Color) -> Result<(), LinkError> {
    Err(LinkError::Usage(without(MODEL)))
}
