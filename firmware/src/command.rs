//! What the host may ask, and what it gets back.
//!
//! Nothing that a host sends can exceed a limit: a command changes the [`Orders`], and the controller clamps and judges those.

use serde::{Deserialize, Serialize};

use crate::block::Target;
use crate::block::{Amplitude, Gate, Orders, Request};
use crate::config::TrimPoint;
use crate::identify::{MOST_MODES, Resonance};
use crate::settings::Kept;
use crate::telemetry::Telemetry;
use crate::units::{Hertz, Turns};

/// A command. On the wire it is its place in this list, so that new ones stand at its end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Who are you?
    Identify,
    /// Fall silent.
    Idle,
    /// Self-test and scan, then fall silent.
    Scan,
    /// Self-test, scan, lock, run.
    Run,
    /// When to let the drive through while running.
    Gate(Gate),
    /// The amplitude to hold; `None` is the configured one.
    Amplitude(Option<Amplitude>),
    /// Forget the fault.
    ClearFault,
    /// Send telemetry every so many blocks; 0 is never.
    TelemetryEvery(u32),
    /// How far beside the resonance to drive.
    Detune(Hertz),
    /// How far lanes 1 and 3 lead lanes 0 and 2; `None` is the configured direction.
    Quadrature(Option<Turns>),
    /// Self-test, and trim the lanes by what they are measured to be; then fall silent.
    Calibrate,
    /// What to do with the lane trims, and with what is kept of them over power-off.
    Settings(Verb),
    /// Which resonances has the last scan found?
    Resonances,
    /// The friction to hold; `None` is the configured target.
    Friction(Option<Target>),
    /// Torso mass of the occupant, kg, as the seat has read it; `None` where it has not.
    Occupant(Option<f32>),
}

/// What to do with the lane trims. What acts and what is kept are two things: each verb says which it is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verb {
    /// Report what acts, at the calibrated frequency with this number, and what is kept.
    Get(u8),
    /// Keep what acts. A calibration does so by itself.
    Store,
    /// Keep nothing. What acts stays.
    Clear,
    /// Trim by nothing from now on. What is kept stays.
    Defaults,
}

/// What the board sends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// The command with this frame's sequence number is obeyed.
    Ack,
    /// It is not.
    Nak(Refusal),
    /// Who this is.
    Identity(Identity),
    /// The latest block; its frame's sequence number counts telemetry frames, so that a lost one is seen.
    Telemetry(Telemetry),
    /// The lane trims.
    Settings(TrimReport),
    /// The resonances of the last scan, those that were heard of since.
    Resonances(ResonanceReport),
}

/// The lane trims, one frequency at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrimReport {
    /// What is kept over power-off.
    pub kept: Kept,
    /// How many calibrated frequencies there are; none is no trims.
    pub points: u8,
    /// The one that was asked for.
    pub point: Option<TrimPoint>,
}

/// The resonances of the last scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResonanceReport {
    /// The one that was chosen; none is that the scan has not ended, or has failed.
    pub chosen: Option<u8>,
    /// At rising frequencies.
    pub found: [Option<Resonance>; MOST_MODES],
}

/// Why a command is not obeyed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The frame was damaged: too long, badly stuffed, or with a wrong checksum.
    Damaged,
    /// The frame is of another protocol version.
    Version,
    /// The frame is whole, but not a command that is known here.
    Unknown,
    /// A number in it is not a number, or negative where it must not be.
    NotPlausible,
    /// Earlier orders have not been taken yet: the block stream stands still.
    Busy,
    /// Only while the drive is silent.
    Driving,
    /// The flash does not do it.
    Flash,
}

/// Who this is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Version of the link's protocol.
    pub protocol: u8,
    /// Version of the firmware: major, minor, patch.
    pub firmware: [u8; 3],
}

impl Command {
    /// The orders after this command; `None` where it changes none.
    pub fn applied_to(&self, orders: &Orders) -> Result<Option<Orders>, Refusal> {
        let mut next = Orders { sequence: orders.sequence.wrapping_add(1), clear_fault: false, ..*orders };
        match *self {
            Command::Identify | Command::TelemetryEvery(_) | Command::Settings(_) | Command::Resonances => return Ok(None),
            Command::Idle => next.request = Request::Idle,
            Command::Scan => (next.request, next.attempt) = (Request::Scan, orders.attempt.wrapping_add(1)),
            Command::Run => (next.request, next.attempt) = (Request::Run, orders.attempt.wrapping_add(1)),
            Command::Calibrate => (next.request, next.attempt) = (Request::Calibrate, orders.attempt.wrapping_add(1)),
            Command::Gate(gate) => next.gate = gate,
            Command::Detune(Hertz(hz)) if !hz.is_finite() => return Err(Refusal::NotPlausible),
            Command::Detune(detune) => next.detune = detune,
            Command::Quadrature(Some(Turns(turns))) if !turns.is_finite() => return Err(Refusal::NotPlausible),
            Command::Quadrature(quadrature) => next.quadrature = quadrature,
            Command::Occupant(Some(kg)) if !(kg.is_finite() && kg >= 0.0) => return Err(Refusal::NotPlausible),
            Command::Occupant(torso_kg) => next.torso_kg = torso_kg,
            Command::Amplitude(amplitude) => {
                let plausible = |x: f32| x.is_finite() && x >= 0.0;
                if !amplitude.is_none_or(|(Amplitude::Volts(x) | Amplitude::MotionalCurrent(x))| plausible(x)) {
                    return Err(Refusal::NotPlausible);
                }
                next.amplitude = amplitude;
            }
            Command::Friction(Some(target)) if !target.is_plausible() => return Err(Refusal::NotPlausible),
            Command::Friction(target) => next.friction = target,
            // Clearing a fault must not start the drive by itself.
            Command::ClearFault => (next.clear_fault, next.request) = (true, Request::Idle),
        }
        Ok(Some(next))
    }
}
