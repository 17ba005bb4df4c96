//! Checks of voltage and current in one block: the phasors, and the raw codes if the lock-in
//! suspects clipping or over-current.

use crate::seam::block::{Codes, SenseBlock, Trips};
use crate::seam::config::{Config, Tracking};
use crate::seam::fault::Fault;
use crate::sense::convert::{CLIPPED_PART, Convert, SenseScale};
use crate::sense::demod::{Sensed, Suspect};
use crate::sense::source::LARGEST_OHM;

/// Fraction of the converter's half range below which the current limit is certainly nearer than
/// the ends of the range: the self-test shifts the zero by at most 5 %.
const LIMIT_INSIDE_REL: f32 = 0.9;
/// Number of samples over the current limit in a block that raise a fault; one may be a glitch of
/// the converter.
const OVER_CURRENT_SAMPLES: usize = 2;
/// Number of consecutive judged blocks with an implausible voltage or current that raise a fault.
const IMPLAUSIBLE_BLOCKS: u32 = 8;
/// Largest ratio between the measured voltage and the fundamental played, in either direction:
/// harmonics leak into the lock-in. A lower voltage is accepted if the current explains it through
/// a source of `LARGEST_OHM`: a load of less resistance takes most of the voltage.
const VOLTAGE_FACTOR: f32 = 2.0;
/// Square of [`VOLTAGE_FACTOR`].
const SQUARE_FACTOR: f32 = VOLTAGE_FACTOR * VOLTAGE_FACTOR;
/// Smallest current of a connected load, relative to that of the nominal capacitance; at the
/// antiresonance a healthy stack takes 1/40.
const OPEN_CURRENT_REL: f32 = 0.01;
/// Smallest voltage that is judged, codes.
const JUDGED_CODES: f32 = 16.0;

/// State of the electrical checks.
#[derive(Clone, Debug)]
pub(super) struct Electrical {
    samples: usize,
    current_limit: f32,
    /// `true` if the current limit is nearer than the ends of the converter's range: a clipped
    /// current is then an over-current.
    limit_is_nearer: bool,
    /// Square of the smallest admittance of a connected load, S².
    least_siemens_squared: f32,
    judged_volts: f32,
    wrong_voltage: u32,
    no_current: u32,
}

impl Electrical {
    /// Builds the checks from the configured limits.
    pub(super) fn build(config: &Config) -> Self {
        let limits = &config.limits;
        let least_c0_f = config.tracking.nominal_c0_f.unwrap_or(Tracking::CAPACITANCES_F.0);
        let least_siemens = OPEN_CURRENT_REL * core::f32::consts::TAU * config.drive.frequency_hz * least_c0_f;
        let (mid, max) = (f32::from(config.front_end.sense_mid_code), f32::from(config.front_end.sense_max_code));
        Electrical {
            samples: config.block_samples.into(),
            current_limit: limits.current_a,
            limit_is_nearer: limits.current_a < LIMIT_INSIDE_REL * config.front_end.ampere_per_lsb * mid.min(max - mid),
            least_siemens_squared: least_siemens * least_siemens,
            judged_volts: JUDGED_CODES * config.front_end.volt_per_lsb.max(config.front_end.drive_volt_per_lsb),
            wrong_voltage: 0,
            no_current: 0,
        }
    }

    /// Resets the counts for a new attempt: silence leaves them unchanged.
    pub(super) fn begin(&mut self) {
        (self.wrong_voltage, self.no_current) = (0, 0);
    }

    /// Checks one block, and returns the fault found. `volts` is the fundamental of the drive
    /// played in the block, as in [`super::Driven::volts`].
    pub(super) fn inspect(
        &mut self,
        convert: &Convert,
        sense: &SenseBlock,
        sensed: &Sensed,
        volts: Option<f32>,
        suspect: Suspect,
    ) -> Option<Fault> {
        // Edges and silence leave the counters unchanged: the bursts of a friction switch may be
        // shorter than `IMPLAUSIBLE_BLOCKS`.
        if let Some(volts) = volts.filter(|&volts| self.is_judged(volts)) {
            // Squares are compared, because a square root takes as long as a period of the lock-in.
            let (played, voltage, current) = (volts * volts, sensed.v.norm_sqr(), sensed.i.norm_sqr());
            let low = SQUARE_FACTOR * voltage < played && !is_explained_by_source(volts, voltage, current);
            let wrong_voltage = voltage > SQUARE_FACTOR * played || low;
            // A constant code has a fundamental too, unless the block is a whole number of periods.
            let no_current = current < self.least_siemens_squared * played || is_constant(&sense.i);
            let count = |counter: u32, wrong: bool| if wrong { counter.saturating_add(1) } else { 0 };
            self.wrong_voltage = count(self.wrong_voltage, wrong_voltage || is_constant(&sense.v));
            self.no_current = count(self.no_current, no_current);
        }

        let tripped = sense.slow.trips.is_some_and(|trips| trips.over_current | trips.amplifier_fault | trips.supply);
        let missed = sense.slow.missed_blocks.is_some_and(|missed| missed > 0);
        let cut = sense.v.len() != self.samples || sense.i.len() != self.samples;
        // Codes are inspected only in a channel that the lock-in suspects.
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

    /// Returns `true` if a drive of `volts`, V peak, is large enough to be judged.
    #[inline]
    pub(super) fn is_judged(&self, volts: f32) -> bool {
        volts > self.judged_volts
    }

    /// Returns `true` if voltage or current of the last judged block were implausible.
    #[inline]
    pub(super) fn is_implausible(&self) -> bool {
        self.wrong_voltage | self.no_current != 0
    }

    /// Returns `true` if too many codes are at an end of the range.
    #[inline(never)]
    fn is_clipped(&self, scale: &SenseScale, codes: &Codes) -> bool {
        scale.clipped(codes) * CLIPPED_PART > self.samples
    }

    /// Returns `true` if too many codes are over the current limit.
    #[inline(never)]
    fn is_over_current(&self, scale: &SenseScale, codes: &Codes) -> bool {
        scale.beyond(codes, self.current_limit) >= OVER_CURRENT_SAMPLES
    }
}

/// Returns the fault of a trip: the amplifier's own fault, its supply, or over-current.
#[cold]
#[inline(never)]
fn tripped_by(sense: &SenseBlock) -> Fault {
    match sense.slow.trips {
        Some(Trips { amplifier_fault: true, .. }) => Fault::AmplifierFault,
        Some(Trips { supply: true, .. }) => Fault::AmplifierSupply,
        _ => Fault::OverCurrent,
    }
}

/// Returns `true` if the current explains a voltage that is too low. `played` is the fundamental
/// played, V; `voltage` and `current` are squares of the measured amplitudes.
#[cold]
#[inline(never)]
fn is_explained_by_source(played: f32, voltage: f32, current: f32) -> bool {
    let expected = played - LARGEST_OHM * fpu::sqrtf(current);
    expected <= 0.0 || SQUARE_FACTOR * voltage >= expected * expected
}

/// Returns `true` if all codes are equal.
fn is_constant(codes: &Codes) -> bool {
    codes.is_sorted_by(|a, b| a == b)
}

#[cfg(test)]
mod tests;
