//! The guard: protection of the stack, the board and the user while the drive is ON.
//!
//! | part | watches | effect |
//! |---|---|---|
//! | `electrical` | voltage, current, lost blocks | faults 11, 13, 20, 21, 23, 28 |
//! | `continuity` | changes of voltage and current under a steady drive | fault 20 |
//! | [`weld`] | belt motion, friction force, energy per metre of belt | mutes (limit 101); faults 40 to 43, 46, 47 |
//! | `heat` | temperature of board and stack, energy taken, mean power | derates (limit 100); fault 44 |
//! | [`on_time`] | time for which the drive is ON | fault 45 |
//!
//! Each part checks every block and returns a fault if it finds one; the first fault in the order
//! of the table is reported. On a board without such sensors and limits the last three parts cost
//! three comparisons a block.

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

/// State of the drive in a block, in addition to the codes measured in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Driven {
    /// Fundamental of the drive played in the block, V peak, if it was constant throughout the
    /// block; `None` at an edge of a burst and for a noise.
    pub volts: Option<f32>,
    /// Purpose of the drive.
    pub stage: Stage,
    /// `true` if the orders and the burst schedule request the drive to be ON.
    pub requested: bool,
    /// `true` if the drive was ON throughout the block.
    pub full: bool,
    /// Amplitude set point, V peak or A peak.
    pub asked: f32,
}

/// Purpose of the drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// The drive is silent.
    #[default]
    Silent,
    /// The drive measures: an interruption ends the measurement.
    Measuring,
    /// The drive follows the resonance: it can be muted and resumed.
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

/// Guard of the drive, with its state.
#[derive(Clone, Debug)]
pub struct Guard {
    electrical: Electrical,
    weld: Weld,
    heat: Heat,
    on_time: OnTime,
    /// `true` if power or ON time have a limit, if the temperature of the stack is known, or if the
    /// drive must be refused because a D-ring's belt has no scale.
    limited: bool,
}

impl Guard {
    /// Builds a guard from the configured limits. Returns an error if an energy limit lacks the
    /// scale of the encoder.
    pub fn build(config: &Config, block_s: f32) -> Result<Self, Error> {
        let weld = Weld::build(config, block_s)?;
        let unscaled = weld.is_unscaled();
        Ok(Guard {
            electrical: Electrical::build(config),
            weld,
            heat: Heat::build(config, block_s),
            on_time: OnTime::build(config, block_s),
            limited: unscaled
                || config.thermometer.resistance_k_per_w.is_some()
                || config.limits.power_w.is_some()
                || config.limits.on_time_s.is_some(),
        })
    }

    /// Resets the weld guard and the counts of implausible blocks for a new attempt.
    pub(crate) fn begin(&mut self) {
        self.weld.begin();
        self.electrical.begin();
    }

    /// Checks voltage, current and the board's reports of one block, and returns the fault found.
    ///
    /// `volts` is the fundamental of the drive played in the block, as in [`Driven::volts`].
    /// `suspect` marks channels whose codes may be clipped or beyond a limit.
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

    /// Returns `true` if a drive of `volts`, V peak, is large enough for the plausibility checks.
    #[inline]
    pub(crate) fn is_judged(&self, volts: f32) -> bool {
        self.electrical.is_judged(volts)
    }

    /// Returns `true` if voltage or current of the last judged block were implausible.
    #[inline]
    pub(crate) fn is_implausible(&self) -> bool {
        self.electrical.is_implausible()
    }

    /// Returns `true` if [`watch`](Self::watch) must be called: a limit or a sensor beyond voltage
    /// and current is present. Most boards have none.
    #[inline]
    pub fn watches(&self, sense: &SenseBlock, belt: &Belt) -> bool {
        self.limited || belt.is_expected() || sense.slow.temperature.is_some()
    }

    /// Checks belt, temperature, power and ON time of one block, and returns the fault found.
    /// Needed only if [`watches`](Self::watches) returns `true`.
    #[inline(never)]
    pub fn watch(
        &mut self,
        convert: &Convert,
        sense: &SenseBlock,
        sensed: &Sensed,
        belt: &Belt,
        driven: &Driven,
    ) -> Option<Fault> {
        // At an edge the amplitude is unknown, but the drive is ON.
        let driving = driven.stage != Stage::Silent && driven.volts.is_none_or(|volts| volts > 0.0);
        let power_w = if driving { 0.5 * (sensed.v.re * sensed.i.re + sensed.v.im * sensed.i.im) } else { 0.0 };
        let weld = self.weld.inspect(belt, sense.slow.force, &weld::Driving { driving, power_w, driven });
        if driving {
            self.heat.limit_power(power_w);
        }
        // The power of all samples, also in silence: a brake returns energy.
        let taken_w = if self.heat.has_balance() { convert.mean_power(&sense.v, &sense.i) } else { 0.0 };
        let heat = self.heat.inspect_temperature(sense.slow.temperature, taken_w);
        let on_time = self.on_time.inspect(driving);
        weld.or(heat).or(on_time)
    }

    /// Returns `true` if the drive must be silent until the belt moves again.
    pub(crate) fn is_muted(&self) -> bool {
        self.weld.is_muted()
    }

    /// Returns `true` if the drive is muted while it is requested.
    pub(crate) fn mutes_request(&self) -> bool {
        self.weld.mutes_request()
    }

    /// Updates the temperature of the stack from the tracker's estimates; needed only occasionally.
    pub(crate) fn update_temperature(&mut self, thermometers: &Thermometers) {
        self.heat.update_temperature(thermometers);
        self.limited |= self.heat.has_reading();
    }

    /// Returns the factor of the amplitude set point, 0.1 to 1.
    pub(crate) fn derating(&self) -> f32 {
        self.heat.factor()
    }
}

#[cfg(test)]
mod tests;
