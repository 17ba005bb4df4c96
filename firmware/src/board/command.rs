//! What the host may ask, and what it gets back.
//!
//! Nothing that a host sends can exceed a limit: a command changes the [`Orders`], and the controller clamps and judges those; and a
//! [parameter](crate::board::parameters) can lower a limit, not raise it.
//!
//! Every frame has one answer:
//!
//! | what comes | is answered by | and |
//! |---|---|---|
//! | damaged, cut short, too long | `Nak(Damaged)`, number 0 | the next frame after a zero is obeyed |
//! | of another protocol version | `Nak(Version)` | nothing happens |
//! | whole, and nothing that is known | `Nak(Unknown)` | nothing happens |
//! | the same frame twice, or frames in another order | each by its own answer | each is obeyed as it comes |
//! | a number that is none, or negative where it must not be | `Nak(NotPlausible)` | nothing happens |
//! | a parameter out of its range, patience beyond an hour | `Nak(OutOfRange)` | nothing happens |
//! | a parameter that nobody knows | `Nak(NoSuchKey)` | nothing happens |
//! | an order, and the queue to the block task is full | `Nak(Busy)` | nothing happens |
//! | a reset, a store, a clear, a set or defaults while it drives, or has been ordered to | `Nak(Driving)` | nothing happens |
//! | a store that the flash does not take | `Nak(Flash)` | what was kept before is kept; what acts stays |
//! | a capture of a lane that there is not, or of more before the trigger than there is room for | `Nak(OutOfRange)` | what was recorded stays |
//! | an arming while one is armed, or full | `Ack` | it begins anew; what was recorded is gone |
//! | a friction without a friction switch, an occupant without a belt, a limit that nothing here could judge | `Nak(NotConfigured)` | nothing happens |
//! | a reading before the capture is full | `Nak(NotCaptured)` | |
//! | a reading beyond its end | `Nak(OutOfRange)` | |
//! | anything of a capture before the last was answered | `Nak(Busy)` | the last is answered |
//! | a fault beyond the last that is kept | a report without one | |
//! | a fault cleared while the emergency stop is pressed | `Ack` | the fault stays |
//! | nothing that is understood, for longer than the patience, while it drives | | fault 12, muted; with a patience of zero it goes on |
//!
//! Settings of another version are named in reports ([`Kept::Version`]), not read, and written over by an order to store or to clear only.

use serde::{Deserialize, Serialize};

use crate::board::capture::{CaptureReport, CaptureVerb, Part};
use crate::board::fault_log::FaultReport;
use crate::board::kept::Kept;
use crate::board::parameters::ParameterReport;
use crate::seam::block::Target;
use crate::seam::block::{Amplitude, Gate, Orders, Request};
use crate::seam::config::{Config, Link, TrimPoint};
use crate::seam::refusal::Refusal;
use crate::seam::telemetry::Telemetry;
use crate::seam::transducer::{MOST_MODES, Resonance};
use crate::seam::units::{Hertz, Turns};

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
    /// What to do with lane trims and parameters, and with what is kept of them over power-off.
    Settings(Verb),
    /// Which resonances has the last scan found?
    Resonances,
    /// The friction to hold; `None` is the configured target.
    Friction(Option<Target>),
    /// Torso mass of the occupant, kg, as the seat has read it; `None` where it has not.
    Occupant(Option<f32>),
    /// The latest block.
    Status,
    /// What to do with the capture.
    Capture(CaptureVerb),
    /// A fault, by how many came after it, and what started the board.
    Faults(u8),
    /// Reset the part, in silence only. The answer leaves before.
    Reset,
    /// How long the host may be silent while the drive is on, s; zero is for ever.
    Patience(f32),
}

/// What to do with lane trims and parameters. What acts, what is set and what is kept are three things: each verb says which it is about. Trims act
/// as soon as they are found; parameters act after a reset, if they have been stored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Verb {
    /// Report the trims that act, at the calibrated frequency with this number, and what is kept.
    Trims(u8),
    /// Report the parameter with this key.
    Get(u8),
    /// Set the parameter with this key.
    Set(u8, f32),
    /// Keep the trims that act and the parameters that are set. A calibration keeps its trims by itself, beside the parameters that are kept.
    Store,
    /// Keep nothing. What acts and what is set stay.
    Clear,
    /// Trim by nothing from now on, and set all parameters to what is built in. What is kept stays.
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
    /// The latest block; nothing before the first.
    Status(Option<Telemetry>),
    /// A parameter.
    Parameter(ParameterReport),
    /// How far the capture is.
    Capture(CaptureReport),
    /// A part of the capture.
    Captured(Part),
    /// A fault.
    Faults(FaultReport),
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

/// Who this is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Version of the link's protocol.
    pub protocol: u8,
    /// Version of the firmware: major, minor, patch.
    pub firmware: [u8; 3],
    /// Its converters.
    pub converters: Converters,
}

/// What a board's converters are, and no setting changes: without it a host cannot tell what a code or a block number is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Converters {
    /// Samples a second, Hz.
    pub sample_hz: u32,
    /// Samples in a block.
    pub block_samples: u16,
    /// Drive lanes that play.
    pub lanes: u8,
    /// The sense code at zero.
    pub sense_mid_code: u16,
    /// The drive code at zero volts.
    pub drive_mid_code: u16,
}

impl Converters {
    /// Those of a configuration.
    pub fn of(config: &Config) -> Self {
        Converters {
            sample_hz: config.sample_hz as u32,
            block_samples: config.block_samples,
            lanes: config.lanes,
            sense_mid_code: config.front_end.sense_mid_code,
            drive_mid_code: config.front_end.drive_mid_code,
        }
    }
}

impl Command {
    /// The orders after this command; `None` where it changes none.
    pub fn applied_to(&self, orders: &Orders) -> Result<Option<Orders>, Refusal> {
        let mut next = Orders { sequence: orders.sequence.wrapping_add(1), clear_fault: false, ..*orders };
        match *self {
            Command::Identify | Command::TelemetryEvery(_) | Command::Settings(_) | Command::Resonances => return Ok(None),
            Command::Status | Command::Capture(_) | Command::Faults(_) | Command::Reset => return Ok(None),
            Command::Patience(seconds) if seconds.is_nan() || seconds < 0.0 => return Err(Refusal::NotPlausible),
            Command::Patience(seconds) if f64::from(seconds) > Link::PATIENCE_S.max => return Err(Refusal::OutOfRange),
            Command::Patience(_) => return Ok(None),
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
