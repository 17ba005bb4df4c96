//! Telemetry: the report of a block. The background task selects some of the reports and sends
//! them.

use serde::{Deserialize, Serialize};

use crate::seam::fault::{Fault, Limit};
use crate::seam::mode::Mode;
use crate::seam::phasor::Phasor;
use crate::seam::transducer::{Listed, Transducer};
use crate::seam::units::{Hertz, Turns, Volts};

/// Report of one block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Telemetry {
    /// Number of the call, from zero; wraps after 38 hours of 32 us blocks.
    pub block: u32,
    /// Sequence number of the last order latched.
    pub orders_sequence: u32,
    /// Mode of the controller.
    pub mode: Mode,
    /// Fault for which the drive is muted.
    pub fault: Option<Fault>,
    /// Reason for which the drive is below its set point.
    pub limit: Option<Limit>,
    /// `true` if the tracker is locked.
    pub locked: bool,
    /// Tuning word of the codes returned, 2^64 per sample rate.
    pub tuning_word: u64,
    /// Frequency of the codes returned.
    pub frequency: Hertz,
    /// Smoothed estimate of the resonance.
    pub resonance: Hertz,
    /// Peak voltage of the codes returned, before the envelope.
    pub drive: Volts,
    /// Mean envelope of the codes returned, 0 to 1.
    pub envelope: f32,
    /// Voltage phasor of the measured block, V peak, relative to the drive played in it.
    pub v: Phasor,
    /// Current phasor of the measured block, A peak.
    pub i: Phasor,
    /// Motional current of the measured block, A peak.
    pub motional_current: Phasor,
    /// Phase of the measured block that the tracker drives to zero.
    pub phase: Turns,
    /// Transducer, once identified.
    pub transducer: Option<Transducer>,
    /// One of the resonances found by the scan; each block carries the next one.
    pub listed: Option<Listed>,
    /// Estimate of the friction switch, after its survey.
    pub friction: Option<FrictionEstimate>,
}

/// Estimate of the contact by the friction switch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionEstimate {
    /// `true` if a survey has identified the contact; otherwise the contact is the nominal one.
    pub identified: bool,
    /// Friction ratio, from the law and the measured tip velocity.
    pub ratio: f32,
    /// Friction ratio from the force sensor; `None` until there is a reference.
    pub force_ratio: Option<f32>,
    /// Kappa at the largest amplitude: the vibration amplitude in Dahl lengths.
    pub kappa: f32,
    /// Relative standard deviation of kappa.
    pub kappa_deviation: f32,
    /// Smallest ratio at this speed.
    pub floor: f32,
}
