//! The guard: is it safe to go on driving?
//!
//! | part | watches | says |
//! |---|---|---|
//! | `electrical` | voltage, current, lost blocks | faults 11, 13, 20, 21, 23, 28 |
//! | `continuity` | how voltage and current of a steady drive change | fault 20 |
//! | [`weld`] | whether the belt moves, what its force says, energy for each metre | mutes (limit 101); faults 40 to 43, 46, 47 |
//! | `heat` | temperature of board and stack, mean power | derates (limit 100); fault 44 |
//! | [`on_time`] | how long the drive is ON | fault 45 |
//!
//! Each looks at every block and names what it finds; the first of them is reported. A board without such sensors and limits pays for
//! three comparisons.

pub(crate) mod continuity;
mod electrical;
pub(crate) mod heat;
pub mod on_time;
pub(crate) mod supervisor;
pub mod weld;

pub use heat::DERATE_K;

use crate::guard::electrical::Electrical;
use crate::guard::heat::{Heat, Thermometers};
use crate::guard::on_time::OnTime;
use crate::guard::weld::Weld;
use crate::seam::block::SenseBlock;
use crate::seam::config::Config;
use crate::seam::error::Error;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::sense::belt::Belt;
use crate::sense::convert::Convert;
use crate::sense::demod::{Sensed, Suspect};

/// What is known of a block besides its codes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Driven {
    /// Fundamental of what was played in it, V peak, where it was the same throughout; `None` at an edge, and of a noise.
    pub volts: Option<f32>,
    /// What the drive is for.
    pub stage: Stage,
    /// The order and the schedule request the drive to be ON.
    pub requested: bool,
    /// The drive was ON throughout the block.
    pub full: bool,
    /// The amplitude asked for, in whatever unit.
    pub asked: f32,
}

/// What the drive is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// Nothing: it is silent.
    #[default]
    Silent,
    /// To measure: it cannot be interrupted and go on.
    Measuring,
    /// To follow the resonance: it can be muted and go on.
    Following,
}

impl From<Mode> for Stage {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Idle | Mode::Fault => Stage::Silent,
            Mode::SelfTest | Mode::Scan | Mode::Calibrate | Mode::Clamped => Stage::Measuring,
            Mode::Lock | Mode::Run => Stage::Following,
        }
    }
}

/// The guard: protection of stack, board and user, with its state.
#[derive(Clone, Debug)]
pub struct Guard {
    electrical: Electrical,
    weld: Weld,
    heat: Heat,
    on_time: OnTime,
    /// Power or ON time have a limit, or there is a D-ring that must not be driven.
    limited: bool,
}

impl Guard {
    /// Builds a guard of the configured limits, and checks these.
    pub fn build(config: &Config, block_s: f32) -> Result<Self, Error> {
        let weld = Weld::build(config, block_s)?;
        let unscaled = weld.is_unscaled();
        Ok(Guard {
            electrical: Electrical::build(config),
            weld,
            heat: Heat::build(config, block_s),
            on_time: OnTime::build(config, block_s),
            limited: unscaled || config.limits.power_w.is_some() || config.limits.on_time_s.is_some(),
        })
    }

    /// A new attempt begins.
    pub(crate) fn begin(&mut self) {
        self.weld.begin();
    }

    /// What voltage and current say is wrong with this block, if anything. `volts` is the fundamental of what was played in it, as
    /// [`Driven`] has it; `suspect` says whether codes of it may be out of order.
    #[inline]
    pub fn inspect(
        &mut self,
        convert: &Convert,
        sense: &SenseBlock,
        sensed: &Sensed,
        volts: Option<f32>,
        suspect: Suspect,
    ) -> Option<Fault> {
        self.electrical.inspect(convert, sense, sensed, volts, suspect)
    }

    /// Whether so many volts are enough to be judged by.
    #[inline]
    pub(crate) fn judges(&self, volts: f32) -> bool {
        self.electrical.judges(volts)
    }

    /// Whether voltage or current are implausible by now, and it is not known yet for how long.
    #[inline]
    pub(crate) fn doubts(&self) -> bool {
        self.electrical.doubts()
    }

    /// Whether there is more to look at than voltage and current; most boards have none.
    #[inline]
    pub fn watches(&self, sense: &SenseBlock, belt: &Belt) -> bool {
        self.limited || belt.is_expected() || sense.slow.temperature.is_some() || self.heat.knows_the_stack()
    }

    /// What more sensors than voltage and current say is wrong, or a limit of its own; where there is [more to look at](Self::watches).
    #[inline(never)]
    pub fn watch(&mut self, sense: &SenseBlock, sensed: &Sensed, belt: &Belt, driven: &Driven) -> Option<Fault> {
        // At an edge it is not known, and something is driven.
        let driving = driven.stage != Stage::Silent && driven.volts.is_none_or(|volts| volts > 0.0);
        let power_w = if driving { 0.5 * (sensed.v.re * sensed.i.re + sensed.v.im * sensed.i.im) } else { 0.0 };
        let weld = self.weld.inspect(belt, sense.slow.force, &weld::Driving { driving, power_w, driven });
        let heat = self.heat.inspect(sense.slow.temperature, driving, power_w);
        let on_time = self.on_time.inspect(driving);
        weld.or(heat).or(on_time)
    }

    /// Whether the drive must be silent until the belt moves again.
    pub(crate) fn is_muted(&self) -> bool {
        self.weld.is_muted()
    }

    /// Whether a drive is requested while it is muted.
    pub(crate) fn mutes(&self) -> bool {
        self.weld.mutes()
    }

    /// Takes what the tracker knows of the stack; now and then is enough.
    pub(crate) fn update_temperature(&mut self, thermometers: &Thermometers) {
        self.heat.update_temperature(thermometers);
    }

    /// What is left of the amplitude asked for, 0.1 to 1.
    pub(crate) fn derating(&self) -> f32 {
        self.heat.factor()
    }
}

#[cfg(test)]
mod tests;
