//! A driven scene as a functional mock-up unit (FMI 3.0, co-simulation): variables, description and
//! the steps of an instance. The functions of the C interface are in the crate `sonoglide-embed`.
//!
//! | kind | inputs | outputs | step |
//! |---|---|---|---|
//! | [`Kind::Board`]: controller, stack and contact | ON or OFF, amplitude, friction ratio, load, speed | friction, tip velocity, power, fault, ... | 1 ms |
//! | [`Kind::Controller`]: the controller alone | codes of voltage and current | codes to play, fault, ... | one block |
//!
//! Standard: Modelica Association, Functional Mock-up Interface 3.0.2, 2024.

mod description;
mod instance;
mod variables;

pub use description::{MODEL_IDENTIFIER, description};
pub use instance::{Instance, StepError};
pub use variables::{Causality, Value, Variable, variables};

use scene::Driven;
use scene::load::Loaded;
use scene::resolved::resolved_toml;

/// Step of a board, s.
pub const BOARD_STEP_S: f64 = 1e-3;
/// Name of the scene in the folder of resources.
pub const SCENE_FILE: &str = "scene.toml";

/// Part of a scene that is a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Controller, stack, contact and converters, with slow inputs and outputs.
    Board,
    /// The controller alone, with the codes of the converters.
    Controller,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 2] = [Kind::Board, Kind::Controller];

    /// Returns the step of a scene, s.
    pub fn step_s(self, scene: &Driven) -> f64 {
        match self {
            Kind::Board => BOARD_STEP_S,
            Kind::Controller => f64::from(scene.controller.block_samples) / scene.sensors.sample_hz,
        }
    }
}

/// Returns the text of a scene that a unit contains: the scene itself, without what only a study
/// needs.
pub fn scene_text(loaded: &Loaded) -> String {
    let mut scene = loaded.scene.clone();
    (scene.grid, scene.comparison, scene.trace) = (None, None, None);
    scene.expect.clear();
    scene.overlay.clear();
    resolved_toml(&scene)
}

/// Returns the token that joins a description to the scene and the kind of a unit: 128 bits in the
/// form of a UUID, from the hash FNV-1a of both.
pub fn token(text: &str, kind: Kind) -> String {
    let hash = |seed: u64| {
        let bytes = [kind as u8].into_iter().chain(env!("CARGO_PKG_VERSION").bytes()).chain(text.bytes());
        bytes.fold(0xcbf2_9ce4_8422_2325 ^ seed, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
    };
    let (high, low) = (hash(0), hash(0x9e37_79b9_7f4a_7c15));
    format!(
        "{:08x}-{:04x}-{:04x}-{:04x}-{:012x}",
        high >> 32,
        high >> 16 & 0xffff,
        high & 0xffff,
        low >> 48,
        low & 0xffff_ffff_ffff
    )
}

#[cfg(test)]
mod tests;
