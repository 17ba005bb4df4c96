//! The weld guard: a belt that stands under the drive melts.
//!
//! ```text
//! encoder --> belt motion --> muted, 40, 41      (ceases to move, lost)
//!        \--> energy -------> 43                 (moves, but too slowly for the power)
//! force -----> force -------> 42, 46             (says that it stands while the encoder counts; is stuck)
//! ```
//!
//! Thesis 3.2.3.1: where the belt ceases to move, the energy suffices to weld it. A layer of 100 um of nylon melts within 7.3 ms of 2.5 kW
//! (`evidence guard`), so that the drive must be OFF within 5 ms. The damping of the resonance does not show it: what a stop changes of it is less
//! than what it is known to (docs/guard.md).

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

/// What is driven in a block.
#[derive(Clone, Copy, Debug)]
pub struct Driving<'a> {
    /// Whether the block is driven.
    pub driving: bool,
    /// Electrical power into the stack, W.
    pub power_w: f32,
    /// What else is known of it.
    pub driven: &'a Driven,
}

/// The weld guard's memory.
#[derive(Clone, Debug)]
pub struct Weld {
    motion: BeltMotion,
    force: ForceWatch,
    energy: EnergyPerLength,
    mutes: bool,
    /// It guards the D-ring of a belt whose motion cannot be known.
    unscaled: bool,
}

impl Weld {
    /// Checks that what the limits need is there.
    pub fn build(config: &Config, block_s: f32) -> Result<Self, Error> {
        Ok(Weld {
            motion: BeltMotion::build(config, block_s),
            force: ForceWatch::build(config, block_s),
            energy: EnergyPerLength::build(config, block_s)?,
            mutes: false,
            unscaled: config.restraint.is_some() && config.front_end.metre_per_count.is_none(),
        })
    }

    /// A new attempt begins: nothing is known of the belt's motion, nor of its force.
    pub(crate) fn begin(&mut self) {
        self.motion.begin();
        self.force.begin();
    }

    /// What is wrong, if anything. Without an encoder nothing is judged, and at a D-ring nothing driven.
    pub fn inspect(&mut self, belt: &Belt, force: Option<f32>, driving: &Driving) -> Option<Fault> {
        if self.unscaled && driving.driven.stage != Stage::Silent {
            return Some(Fault::BeltScaleMissing);
        }
        if !belt.is_expected() {
            return None;
        }
        let Driving { driving: on, power_w, driven } = *driving;
        let motion = self.motion.step(belt, driven.stage, on, driven.requested);
        self.mutes = self.motion.is_muted() && driven.requested;
        let energy = self.energy.step(power_w, belt.fresh_counts());
        let force = self.force.step(force, on, driven.full, driven.asked);
        motion.or(energy).or(force)
    }

    /// Whether the drive must be silent until the belt moves again.
    pub fn is_muted(&self) -> bool {
        self.motion.is_muted()
    }

    /// Whether it must refuse any drive.
    pub(crate) fn is_unscaled(&self) -> bool {
        self.unscaled
    }

    /// Whether a drive is requested while it is muted.
    pub(crate) fn mutes(&self) -> bool {
        self.mutes
    }
}
