//! Commands of the host, and replies of the board.
//!
//! Nothing that a host sends can exceed a limit: a command changes the [`Orders`], and the controller clamps and judges those; and a
//! [parameter](crate::board::parameters) can lower a limit, not raise it.
//!
//! Every frame has one answer:
//!
//! | frame | answer | effect |
//! |---|---|---|
//! | damaged, cut short, too long | `Nak(Damaged)`, number 0 | the next frame after a zero is obeyed |
//! | of another protocol version | `Nak(Version)` | nothing happens |
//! | `Identify`, in any session | `Identity`, with a new session | the former session has ended; the drive goes on as it was, and this is no sign of life |
//! | `Identify` with the number of the one before, and nothing of its session since | `Identity`, with the same session | nothing happens: a copy of the same frame |
//! | whole, of another session; any but `Identify` before the first of these | `Nak(Session)` | nothing happens, and this is no sign of life |
//! | whole, and nothing that is known | `Nak(Unknown)` | nothing happens |
//! | the same frame twice, or frames in another order | each by its own answer | each is obeyed as it comes |
//! | a number that is none, or negative where it must not be | `Nak(NotPlausible)` | nothing happens |
//! | a parameter out of its range, a host timeout beyond an hour | `Nak(OutOfRange)` | nothing happens |
//! | an unknown parameter | `Nak(NoSuchKey)` | nothing happens |
//! | an order, and the queue to the block task is full | `Nak(Busy)` | nothing happens |
//! | a reset, a store, a clear, a set or defaults while it drives, or has been ordered to | `Nak(Driving)` | nothing happens |
//! | a store that the flash does not take | `Nak(Flash)` | what was stored before stays stored, or the new is in one of its two copies; active values stay |
//! | a store of parameters that do not build together | `Nak(DoesNotBuild)`, with the key of one | what was stored before stays stored |
//! | a capture of a lane that there is not, or of more before the trigger than there is room for | `Nak(OutOfRange)` | what was recorded stays |
//! | an arming while one is armed, or full | `Ack` | the capture restarts; what was recorded is gone |
//! | a friction without a friction switch, an occupant without a belt, a limit that nothing here could judge | `Nak(NotConfigured)` | nothing happens |
//! | a run, scan or calibration at a D-ring without the scale of its belt's encoder | `Nak(NoBeltScale)` | nothing happens |
//! | a run, scan or calibration where a stored limit may not act: settings that could not be read at the start, a limit that nothing here judges | `Nak(LimitsUnsure)` | nothing happens |
//! | a parameter of what the image leaves out | `Nak(LeftOut)` | nothing happens |
//! | a parameter that acts only beside one that is not set | `Nak(NotConfigured)` | nothing happens |
//! | a reading before the capture is full | `Nak(NotCaptured)` | |
//! | a reading beyond its end | `Nak(OutOfRange)` | |
//! | anything of a capture before the last was answered | `Nak(Busy)` | the last is answered |
//! | an update while it drives, or has been ordered to | `Nak(Driving)` | nothing happens |
//! | an update for a board without a first stage | `Nak(NotConfigured)` | nothing happens |
//! | a part of an update out of order, or an order to install what was not checked | `Nak(OutOfRange)` | what was received stays |
//! | an update that is not one for this board | a report that names the reason | what was received is not started |
//! | a fault beyond the last in the log | a report without one | |
//! | a fault cleared while the emergency stop is pressed | `Ack` | the fault stays |
//! | nothing of the session that is understood, for longer than the host timeout, while it drives | | fault 12, muted; with a timeout of zero it goes on |
//!
//! A session has a number that the board makes from the number that the host has drawn, so that a frame which was left over in a buffer, and one of
//! another program, is not obeyed; nor is a whole conversation that comes a second time: its `Identify` begins a session that its other frames do not know.
//! A session ends with the next one, or with a reset.
//!
//! Settings of another version are named in reports ([`StoredState::Version`]), not read, and written over by an order to store or to clear only;
//! until then, and a reset, nothing is driven, nor is it where both copies of the settings are damaged: they may have had lower limits.

use serde::{Deserialize, Serialize};

use crate::board::capture::{CaptureReport, CaptureVerb, Part};
use crate::board::fault_log::FaultReport;
use crate::board::parameters::ParameterReport;
use crate::board::stored_state::StoredState;
use crate::board::update::{UpdateReport, UpdateVerb};
use crate::seam::block::Target;
use crate::seam::block::{Amplitude, Gate, Orders, Request};
use crate::seam::config::{Config, Link, TrimPoint};
use crate::seam::refusal::Refusal;
use crate::seam::telemetry::Telemetry;
use crate::seam::transducer::{MOST_MODES, Resonance};
use crate::seam::units::{Hertz, Turns};

/// A command of the host. Its number on the wire is its place in this list, so that new commands stand at the end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Asks for the identity of the board, and begins a session; with a number that the host has drawn by chance, so that it knows the answer to its own.
    Identify(u32),
    /// Ends the drive: the controller falls silent.
    Idle,
    /// Runs the self-test and the scan, then ends the drive.
    Scan,
    /// Runs the self-test, the scan and the lock, then drives.
    Run,
    /// Sets when the drive is let through while running.
    Gate(Gate),
    /// Sets the amplitude; `None` is the configured one.
    Amplitude(Option<Amplitude>),
    /// Clears the fault, and ends the request to drive.
    ClearFault,
    /// Sends telemetry every so many blocks; 0 is never.
    TelemetryEvery(u32),
    /// Sets the offset of the drive from the resonance.
    Detune(Hertz),
    /// Sets by how much lanes 1 and 3 lead lanes 0 and 2; `None` is the configured direction.
    Quadrature(Option<Turns>),
    /// Runs the self-test, measures the lanes and trims them; then ends the drive.
    Calibrate,
    /// Reads or changes lane trims, parameters and the stored settings.
    Settings(Verb),
    /// Asks for the resonances that the last scan has found.
    Resonances,
    /// Sets the target of the friction switch; `None` is the configured one.
    Friction(Option<Target>),
    /// Sets the torso mass of the occupant, kg, as the seat has read it; `None` where there is no reading.
    Occupant(Option<f32>),
    /// Asks for the telemetry of the latest block.
    Status,
    /// Arms, reads or ends a capture.
    Capture(CaptureVerb),
    /// Asks for a fault of the log, by how many came after it, and for what started the board.
    Faults(u8),
    /// Resets the board, in silence only. The answer is sent before.
    Reset,
    /// Sets the host timeout: how long the host may be silent while the drive is on, s; zero is for ever.
    Patience(f32),
    /// Receives, checks or installs another image, in silence only, or asks how that stands.
    Update(UpdateVerb),
}

/// Operation on lane trims and parameters. Active, set and stored values are three things: each verb names those that it changes. Trims act
/// as soon as they are found; parameters act after a reset, if they have been stored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Verb {
    /// Reports the active trims, at the calibrated frequency with this number, and the state of the stored settings.
    Trims(u8),
    /// Reports the parameter with this key.
    Get(u8),
    /// Sets the parameter with this key.
    Set(u8, f32),
    /// Stores the active trims and the set parameters. A calibration stores its trims by itself, beside the parameters that are stored already.
    Store,
    /// Clears the stored settings. Active and set values stay.
    Clear,
    /// Removes the active trims, and sets all parameters to their defaults. The stored settings stay.
    Defaults,
    /// Reports how often settings were stored.
    Stores,
}

/// A frame of the board: the answer to a command, or telemetry.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// The command with this frame's sequence number was accepted.
    Ack,
    /// The command with this frame's sequence number was refused.
    Nak(Refusal),
    /// Identity of the board.
    Identity(Identity),
    /// Telemetry of the latest block; the frame's sequence number counts telemetry frames, so that a lost one is seen.
    Telemetry(Telemetry),
    /// The lane trims at one frequency.
    Settings(TrimReport),
    /// The resonances of the last scan that were reported so far.
    Resonances(ResonanceReport),
    /// Telemetry of the latest block; `None` before the first.
    Status(Option<Telemetry>),
    /// The values of a parameter.
    Parameter(ParameterReport),
    /// State of the capture.
    Capture(CaptureReport),
    /// A part of a full capture.
    Captured(Part),
    /// A fault of the log.
    Faults(FaultReport),
    /// State of the update.
    Update(UpdateReport),
    /// How often settings were stored: each time wears the flash.
    Stores(u32),
}

/// Report of the lane trims, one frequency at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrimReport {
    /// State of the stored settings.
    pub stored: StoredState,
    /// Number of calibrated frequencies; zero where there are no trims.
    pub points: u8,
    /// The trims at the frequency that was asked for.
    pub point: Option<TrimPoint>,
}

/// Report of the resonances of the last scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResonanceReport {
    /// Place of the chosen resonance; `None` where the scan has not ended, or has failed.
    pub chosen: Option<u8>,
    /// The resonances, at rising frequencies.
    pub found: [Option<Resonance>; MOST_MODES],
}

/// Identity of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Version of the link's protocol.
    pub protocol: u8,
    /// Version of the firmware: major, minor, patch.
    pub firmware: [u8; 3],
    /// The converters of the board.
    pub converters: Converters,
    /// The session that has begun: all further commands have this number in their frames. Never [none](crate::board::link::NO_SESSION).
    pub session: u32,
}

/// Properties of a board's converters, which no setting changes: with them a host converts codes and block numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Converters {
    /// Sample rate of the converters, Hz.
    pub sample_hz: u32,
    /// Samples of a block.
    pub block_samples: u16,
    /// Number of drive lanes in use.
    pub lanes: u8,
    /// Sense code at zero input.
    pub sense_mid_code: u16,
    /// Drive code at zero volts.
    pub drive_mid_code: u16,
}

impl Converters {
    /// The converters of a configuration.
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
    /// The orders after this command; `None` for a command that changes none.
    pub fn applied_to(&self, orders: &Orders) -> Result<Option<Orders>, Refusal> {
        let mut next = Orders { sequence: orders.sequence.wrapping_add(1), clear_fault: false, ..*orders };
        match *self {
            Command::Identify(_) | Command::TelemetryEvery(_) | Command::Settings(_) | Command::Resonances => return Ok(None),
            Command::Status | Command::Capture(_) | Command::Faults(_) | Command::Reset | Command::Update(_) => return Ok(None),
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
