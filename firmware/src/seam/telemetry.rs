//! Telemetry: the report of a block. The background task thins it out and sends it.

use serde::{Deserialize, Serialize};

use crate::seam::fault::{Fault, Limit};
use crate::seam::mode::Mode;
use crate::seam::phasor::Phasor;
use crate::seam::transducer::{Listed, Transducer};
use crate::seam::units::{Hertz, Turns, Volts};

/// The report of one block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Telemetry {
    /// Which call this is, counted from zero; wraps after 38 hours of 32 us blocks.
    pub block: u32,
    /// The last order latched.
    pub orders_sequence: u32,
    /// What the controller is doing.
    pub mode: Mode,
    /// Why it is muted.
    pub fault: Option<Fault>,
    /// What keeps it from doing what was asked.
    pub limit: Option<Limit>,
    /// Whether the tracker is locked.
    pub locked: bool,
    /// Tuning word of the codes returned, 2^64 a sample rate.
    pub tuning_word: u64,
    /// Frequency of the codes returned.
    pub frequency: Hertz,
    /// The tracker's smoothed estimate of the resonance.
    pub resonance: Hertz,
    /// Peak voltage of the codes returned, before the envelope.
    pub drive: Volts,
    /// Mean envelope of the codes returned, 0 to 1.
    pub envelope: f32,
    /// Voltage phasor of the measured block, V peak, relative to the drive that was played in it.
    pub v: Phasor,
    /// Current phasor of the measured block, A peak.
    pub i: Phasor,
    /// Motional current of the measured block, A peak.
    pub motional_current: Phasor,
    /// Phase that the tracker drives to zero, of the measured block.
    pub phase: Turns,
    /// The transducer, once identified.
    pub transducer: Option<Transducer>,
    /// One of the resonances that the scan has found, each in its turn.
    pub listed: Option<Listed>,
    /// Estimate of the friction switch, once its survey is over.
    pub friction: Option<FrictionEstimate>,
}

/// The friction switch's estimate of the contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionEstimate {
    /// The survey is over, and has found the contact; if not, the contact is the nominal one.
    pub identified: bool,
    /// Friction ratio, by the law and the tip velocity that is measured.
    pub ratio: f32,
    /// Friction ratio by the force sensor; not before there is something to compare with.
    pub force_ratio: Option<f32>,
    /// Largest vibration amplitude, in Dahl lengths: kappa there.
    pub kappa: f32,
    /// Standard deviation of kappa, relative.
    pub kappa_deviation: f32,
    /// The least ratio at this speed.
    pub floor: f32,
}
