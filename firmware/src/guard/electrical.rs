//! What voltage and current say: one block's phasors, and its raw codes where the lock-in has seen some that may be out of order.

use crate::seam::block::{Codes, SenseBlock, Trips};
use crate::seam::config::{Config, Tracking};
use crate::seam::fault::Fault;
use crate::sense::convert::{CLIPPED_PART, Convert, SenseScale};
use crate::sense::demod::{Sensed, Suspect};
use crate::sense::source::LARGEST_OHM;

/// Part of the range within which a limit is certainly nearer than its ends: a self-test moves the zero by a twentieth at most.
const NEARER: f32 = 0.9;
/// Samples of a block over the current limit that make a fault: one may be a glitch of the converter.
const OVER_CURRENT_SAMPLES: usize = 2;
/// Blocks that are judged, one after the other, for which the voltage or the current may be implausible before that counts.
const IMPLAUSIBLE_BLOCKS: u32 = 8;
/// The voltage may be this many times smaller or larger than the fundamental that was played (harmonics leak into the lock-in), and smaller by what
/// the current makes of the source's resistance: a resonance of less than that takes most of the voltage away.
const VOLTAGE_FACTOR: f32 = 2.0;
const SQUARE_FACTOR: f32 = VOLTAGE_FACTOR * VOLTAGE_FACTOR;
/// Smallest current, relative to what the nominal capacitance takes; at the antiresonance a healthy stack takes a fortieth.
const OPEN_PART: f32 = 0.01;
/// Voltages below this many codes are not judged.
const JUDGED_CODES: f32 = 16.0;

/// What is remembered from block to block.
#[derive(Clone, Debug)]
pub(super) struct Electrical {
    samples: usize,
    current_limit: f32,
    /// The limit is nearer than the ends of the converter's range: what stands there is beyond it.
    limit_is_nearer: bool,
    /// Square of the smallest admittance of a load that is there.
    least_siemens_squared: f32,
    judged_volts: f32,
    wrong_voltage: u32,
    no_current: u32,
}

impl Electrical {
    /// A watch that keeps the configured limits.
    pub(super) fn build(config: &Config) -> Self {
        let limits = &config.limits;
        let least_c0_f = config.tracking.nominal_c0_f.unwrap_or(Tracking::CAPACITANCES_F.0);
        let least_siemens = OPEN_PART * core::f32::consts::TAU * config.drive.frequency_hz * least_c0_f;
        let (mid, max) = (f32::from(config.front_end.sense_mid_code), f32::from(config.front_end.sense_max_code));
        Electrical {
            samples: config.block_samples.into(),
            current_limit: limits.current_a,
            limit_is_nearer: limits.current_a < NEARER * config.front_end.ampere_per_lsb * mid.min(max - mid),
            least_siemens_squared: least_siemens * least_siemens,
            judged_volts: JUDGED_CODES * config.front_end.volt_per_lsb.max(config.front_end.drive_volt_per_lsb),
            wrong_voltage: 0,
            no_current: 0,
        }
    }

    /// What is wrong with this block, if anything. `volts` is the fundamental of what was played in it, as [`super::Driven`] has it.
    pub(super) fn inspect(
        &mut self,
        convert: &Convert,
        sense: &SenseBlock,
        sensed: &Sensed,
        volts: Option<f32>,
        suspect: Suspect,
    ) -> Option<Fault> {
        // An edge and silence say nothing, and the counts stay as they are: the bursts of a friction switch may be shorter than what is counted to.
        if let Some(volts) = volts.filter(|&volts| self.judges(volts)) {
            // Squares are compared: a root takes as long as a period of the lock-in.
            let (played, voltage, current) = (volts * volts, sensed.v.norm_sqr(), sensed.i.norm_sqr());
            let low = SQUARE_FACTOR * voltage < played && !sags(volts, voltage, current);
            let wrong_voltage = voltage > SQUARE_FACTOR * played || low;
            // A constant has a fundamental too where a block is no whole number of periods.
            let no_current = current < self.least_siemens_squared * played || is_constant(&sense.i);
            let count = |counter: u32, wrong: bool| if wrong { counter.saturating_add(1) } else { 0 };
            self.wrong_voltage = count(self.wrong_voltage, wrong_voltage || is_constant(&sense.v));
            self.no_current = count(self.no_current, no_current);
        }

        let tripped = sense.slow.trips.is_some_and(|trips| trips.over_current | trips.amplifier_fault | trips.supply);
        let missed = sense.slow.missed_blocks.is_some_and(|missed| missed > 0);
        let cut = sense.v.len() != self.samples || sense.i.len() != self.samples;
        // Clipping and over-current are looked for where there can be any.
        let Suspect { v: look_at_v, i: look_at_i, .. } = suspect;
        let over_current = look_at_i && self.is_over_current(&convert.i, &sense.i);
        if missed || cut {
            Some(Fault::LateBlock)
        } else if look_at_v && self.is_clipped(&convert.v, &sense.v) {
            Some(Fault::SenseSaturated)
        } else if tripped || over_current {
            Some(tripped_by(sense))
        } else if look_at_i && !self.limit_is_nearer && self.is_clipped(&convert.i, &sense.i) {
            Some(Fault::SenseSaturated)
        } else if self.wrong_voltage >= IMPLAUSIBLE_BLOCKS {
            Some(Fault::SensorImplausible)
        } else if self.no_current >= IMPLAUSIBLE_BLOCKS {
            Some(Fault::LoadOpen)
        } else {
            None
        }
    }

    /// Whether so many volts are enough to be judged by.
    #[inline]
    pub(super) fn judges(&self, volts: f32) -> bool {
        volts > self.judged_volts
    }

    /// Whether voltage or current are implausible by now, and it is not known yet for how long.
    #[inline]
    pub(super) fn doubts(&self) -> bool {
        self.wrong_voltage | self.no_current != 0
    }

    /// Whether too many codes stand at an end of the range.
    #[inline(never)]
    fn is_clipped(&self, scale: &SenseScale, codes: &Codes) -> bool {
        scale.clipped(codes) * CLIPPED_PART > self.samples
    }

    /// Whether too many codes are beyond the current limit.
    #[inline(never)]
    fn is_over_current(&self, scale: &SenseScale, codes: &Codes) -> bool {
        scale.beyond(codes, self.current_limit) >= OVER_CURRENT_SAMPLES
    }
}

/// What has tripped: an amplifier that says so itself, its supply, or the current.
#[cold]
#[inline(never)]
fn tripped_by(sense: &SenseBlock) -> Fault {
    match sense.slow.trips {
        Some(Trips { amplifier_fault: true, .. }) => Fault::AmplifierFault,
        Some(Trips { supply: true, .. }) => Fault::AmplifierSupply,
        _ => Fault::OverCurrent,
    }
}

/// Whether the current explains a voltage that is low, of what was played, V; squares of the other two.
#[cold]
#[inline(never)]
fn sags(played: f32, voltage: f32, current: f32) -> bool {
    let expected = played - LARGEST_OHM * libm::sqrtf(current);
    expected <= 0.0 || SQUARE_FACTOR * voltage >= expected * expected
}

/// Whether all codes are the same.
fn is_constant(codes: &Codes) -> bool {
    codes.is_sorted_by(|a, b| a == b)
}

#[cfg(test)]
mod tests;
