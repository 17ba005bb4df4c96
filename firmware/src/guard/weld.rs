//! The weld guard: under ultrasound a belt at rest melts.
//!
//! ```text
//! encoder --> belt motion --> muted, 40, 41      (belt stops; encoder lost)
//!        \--> energy -------> 43                 (belt too slow for the power)
//! force -----> force -------> 42, 46             (belt at rest while the encoder counts; channel stuck)
//! ```
//!
//! Thesis 3.2.3.1: if the belt stops, the energy suffices to weld it. At 2.5 kW a layer of 100 um
//! of nylon melts within 7.3 ms (`evidence guard`); the drive must therefore be OFF within 5 ms.
//! The damping of the resonance cannot detect a stop: its change is smaller than its uncertainty
//! (docs/evidence/guard.md).

pub mod belt_motion;
pub mod energy;
pub mod force;

use super::{Driven, Stage};
use crate::guard::weld::belt_motion::BeltMotion;
use crate::guard::weld::energy::EnergyPerLength;
use crate::guard::weld::force::ForceWatch;
use crate::seam::config::Config;
use crate::seam::error::Error;
use crate::seam::fault::Fault;
use crate::sense::belt::Belt;

/// Drive of a block.
#[derive(Clone, Copy, Debug)]
pub struct Driving<'a> {
    /// `true` if the drive was ON in the block.
    pub driving: bool,
    /// Electrical power into the stack, W.
    pub power_w: f32,
    /// State of the drive.
    pub driven: &'a Driven,
}

/// Weld guard, with its state.
#[derive(Clone, Debug)]
pub struct Weld {
    motion: BeltMotion,
    force: ForceWatch,
    energy: EnergyPerLength,
    mutes_request: bool,
    /// `true` if the belt of a D-ring has no scale, so that its motion cannot be known.
    unscaled: bool,
}

impl Weld {
    /// Builds the guard. Returns an error if a limit needs an encoder scale that is not configured.
    pub fn build(config: &Config, block_s: f32) -> Result<Self, Error> {
        Ok(Weld {
            motion: BeltMotion::build(config, block_s),
            force: ForceWatch::build(config, block_s),
            energy: EnergyPerLength::build(config, block_s)?,
            mutes_request: false,
            unscaled: config.restraint.is_some() && config.front_end.metre_per_count.is_none(),
        })
    }

    /// Resets the state for a new attempt: nothing is known of the belt's motion or force.
    pub(crate) fn begin(&mut self) {
        self.motion.begin();
        self.force.begin();
    }

    /// Checks one block, and returns the fault found. Without an encoder no block is checked; at a
    /// D-ring without a scale every drive is a fault.
    pub fn inspect(&mut self, belt: &Belt, force: Option<f32>, driving: &Driving) -> Option<Fault> {
        if self.unscaled && driving.driven.stage != Stage::Silent {
            return Some(Fault::BeltScaleMissing);
        }
        if !belt.is_expected() {
            return None;
        }
        let Driving { driving: on, power_w, driven } = *driving;
        let motion = self.motion.step(belt, driven.stage, on, driven.requested);
        self.mutes_request = self.motion.is_muted() && driven.requested;
        let energy = self.energy.step(power_w, belt.fresh_counts());
        let force = self.force.step(force, on, driven.full, driven.asked);
        motion.or(energy).or(force)
    }

    /// Returns `true` if the drive must be silent until the belt moves again.
    pub fn is_muted(&self) -> bool {
        self.motion.is_muted()
    }

    /// Returns `true` if every drive must be refused because the belt has no scale.
    pub(crate) fn is_unscaled(&self) -> bool {
        self.unscaled
    }

    /// Returns `true` if the drive is muted while it is requested.
    pub(crate) fn mutes_request(&self) -> bool {
        self.mutes_request
    }
}
