//! Stand-in for the model of the microcontroller in a build without it: every use returns an error
//! with the build that has it.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::link::LinkArgs;
use super::{Color, Exit, missing_part, mistake};
use link::link_error::LinkError;
use scene::Driven;
use sim::processor::Processor;
use sim::run::RunError;

const MODEL: &str = "model of the microcontroller (`--board`, `board:SCENE`)";

/// Flashed image, which this build cannot run.
pub(super) enum Flashed {}

impl Flashed {
    /// Returns the error of a build without the model.
    pub(super) fn new(_: Option<&Path>, _: &Driven, _: Option<f64>, _: bool) -> anyhow::Result<Self> {
        Err(mistake(Exit::Usage, missing_part(MODEL)))
    }

    /// Cannot be called.
    pub(super) fn start(&self, _: &Driven, _: &'static AtomicBool) -> Result<Box<dyn Processor>, RunError> {
        match *self {}
    }
}

/// Returns the error of a build without the model.
pub(super) fn talk(_: &LinkArgs, _: &Driven, _: Color) -> Result<(), LinkError> {
    Err(LinkError::Usage(missing_part(MODEL)))
}
