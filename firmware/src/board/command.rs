//! Commands of the host, and replies of the board.
//!
//! A host cannot exceed a limit. A command only changes the [`Orders`], which the controller clamps
//! and checks, and a [parameter](crate::board::parameters) can lower a limit but not raise it.
//!
//! Each frame has one answer:
//!
//! | frame | answer | effect |
//! |---|---|---|
//! | damaged, truncated or too long | `Nak(Damaged)`, number 0 | the next frame after a zero is obeyed |
//! | of another protocol version | `Nak(Version)` | none |
//! | `Identify`, in any session | `Identity`, with a new session | the former session ends; the drive continues; not a sign of life |
//! | `Identify` with the number of the previous one, if its session has had no other frame | `Identity`, with the same session | none: a copy of the same frame |
//! | intact, but of another session; any but `Identify` before the first session | `Nak(Session)` | none; not a sign of life |
//! | intact, but unknown | `Nak(Unknown)` | none |
//! | the same frame twice, or frames out of order | one for each frame | each is obeyed as it arrives |
//! | a value that is not a number, or negative where it must not be | `Nak(NotPlausible)` | none |
//! | a parameter out of its range, a host timeout above one hour | `Nak(OutOfRange)` | none |
//! | an unknown parameter | `Nak(NoSuchKey)` | none |
//! | an order while the queue to the block task is full | `Nak(Busy)` | none |
//! | a reset, a store, a clear, a set or defaults while the board drives, or has been ordered to | `Nak(Driving)` | none |
//! | a store that the flash does not accept | `Nak(Flash)` | the previous settings remain stored, or one of the two copies has the new ones; active values stay |
//! | a store of parameters that do not build together | `Nak(DoesNotBuild)`, with the key of one | the previous settings remain stored |
//! | a capture of a missing lane, or of more samples before the trigger than fit | `Nak(OutOfRange)` | the recorded samples stay |
//! | an arming while a capture is armed or full | `Ack` | the capture restarts; the recorded samples are lost |
//! | a friction set point without a friction switch, an occupant without a belt, a limit that the board cannot check | `Nak(NotConfigured)` | none |
//! | a run, scan or calibration at a D-ring without the scale of the belt's encoder | `Nak(NoBeltScale)` | none |
//! | a run, scan or calibration while a stored limit may not act: settings that could not be read at the start, or a limit that the board cannot check | `Nak(LimitsUnsure)` | none |
//! | a parameter of a feature that the image leaves out | `Nak(LeftOut)` | none |
//! | a parameter that acts only with another one that is not set | `Nak(NotConfigured)` | none |
//! | a reading before the capture is full | `Nak(NotCaptured)` | |
//! | a reading beyond the end of the capture | `Nak(OutOfRange)` | |
//! | a capture command before the last one was answered | `Nak(Busy)` | the last one is answered |
//! | a release of a muted amplifier while the board drives, or has been ordered to | `Nak(Driving)` | none |
//! | an update while the board drives, or has been ordered to | `Nak(Driving)` | none |
//! | an update for a board without a first stage | `Nak(NotConfigured)` | none |
//! | a part of an update out of order, or an order to install an unchecked update | `Nak(OutOfRange)` | the received part stays |
//! | an update that is not for this board | a report with the reason | the update is not started |
//! | a fault beyond the last in the log | a report without a fault | |
//! | a fault cleared while the emergency stop is pressed | `Ack` | the fault stays |
//! | no known command of the session for longer than the host timeout while the board drives | | fault 12, muted; with a timeout of zero the drive continues |
//!
//! The board derives the session number from the random number of the host. Therefore it does not
//! obey a frame left in a buffer, or a frame of another program. It does not obey a replayed
//! conversation either: the `Identify` begins a session whose number the other frames do not have.
//! A session ends with the next one, or with a reset.
//!
//! Settings of another version are reported ([`StoredState::Version`]) but not used. Only an order
//! to store or to clear overwrites them, and the board does not drive before that order and a
//! reset. It does not drive either if both copies of the settings are damaged, because they may
//! have had lower limits.

use serde::{Deserialize, Serialize};

use crate::board::capture::{CaptureReport, CaptureVerb, Part};
use crate::board::fault_log::FaultReport;
use crate::board::hardware::HardwareReport;
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

/// Command of the host. Its number on the wire is its place in this list; new commands are
/// appended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Requests the identity of the board, and begins a session. The host draws the number at
    /// random, and recognizes the answer by it.
    Identify(u32),
    /// Stops the drive.
    Idle,
    /// Runs the self-test and the scan, then stops the drive.
    Scan,
    /// Runs the self-test, the scan and the lock, then drives.
    Run,
    /// Sets the gate of the drive while running.
    Gate(Gate),
    /// Sets the amplitude; `None` restores the configured one.
    Amplitude(Option<Amplitude>),
    /// Clears the fault, and withdraws the request to drive.
    ClearFault,
    /// Sends telemetry at this interval, blocks; 0 is never.
    TelemetryEvery(u32),
    /// Sets the offset of the drive from the resonance.
    Detune(Hertz),
    /// Sets the lead of lanes 1 and 3 over lanes 0 and 2; `None` restores the configured direction.
    Quadrature(Option<Turns>),
    /// Runs the self-test, measures the lanes and trims them, then stops the drive.
    Calibrate,
    /// Reads or changes lane trims, parameters and the stored settings.
    Settings(Verb),
    /// Requests the resonances found by the last scan.
    Resonances,
    /// Sets the target of the friction switch; `None` restores the configured one.
    Friction(Option<Target>),
    /// Sets the torso mass of the occupant as read by the seat, kg; `None` without a reading.
    Occupant(Option<f32>),
    /// Requests the telemetry of the latest block.
    Status,
    /// Arms, reads or ends a capture.
    Capture(CaptureVerb),
    /// Requests a fault of the log, by the number of later faults, and the cause of the last start.
    Faults(u8),
    /// Resets the board after the answer has been sent; in silence only.
    Reset,
    /// Sets the host timeout: the longest silence of the host while the drive is on, s; zero
    /// disables it.
    Patience(f32),
    /// Receives, checks or installs another image, in silence only, or reports the state of the
    /// update.
    Update(UpdateVerb),
    /// Requests the microcontroller, its clock, and the longest block.
    Hardware,
    /// Keeps the enable of the amplifier low, also while the controller plays, until it is released
    /// in silence or the board restarts.
    Mute(bool),
}

/// Operation on lane trims and parameters. Active, set and stored values are distinct; each verb
/// states which of them it changes. Trims act as soon as they are found; parameters act after a
/// reset, if they have been stored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Verb {
    /// Reports the active trims, at the calibrated frequency with this number, and the state of the
    /// stored settings.
    Trims(u8),
    /// Reports the parameter with this key.
    Get(u8),
    /// Sets the parameter with this key.
    Set(u8, f32),
    /// Stores the active trims and the set parameters. A calibration stores its trims by itself,
    /// and keeps the parameters that are stored already.
    Store,
    /// Clears the stored settings. Active and set values stay.
    Clear,
    /// Removes the active trims, and sets all parameters to their defaults. The stored settings
    /// stay.
    Defaults,
    /// Reports the number of stores so far.
    Stores,
}

/// Frame of the board: the answer to a command, or telemetry.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// The command with this frame's sequence number was accepted.
    Ack,
    /// The command with this frame's sequence number was refused.
    Nak(Refusal),
    /// Identity of the board.
    Identity(Identity),
    /// Telemetry of the latest block. The sequence number counts telemetry frames, so that the host
    /// detects lost ones.
    Telemetry(Telemetry),
    /// The lane trims at one frequency.
    Settings(TrimReport),
    /// Resonances of the last scan, as far as the telemetry has reported them.
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
    /// Number of stores so far; each wears the flash.
    Stores(u32),
    /// Microcontroller, its clock, and the longest block.
    Hardware(HardwareReport),
}

/// Report of the lane trims, one frequency at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrimReport {
    /// State of the stored settings.
    pub stored: StoredState,
    /// Number of calibrated frequencies; zero without trims.
    pub points: u8,
    /// Trims at the requested frequency.
    pub point: Option<TrimPoint>,
}

/// Report of the resonances of the last scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResonanceReport {
    /// Index of the chosen resonance; `None` if the scan has not ended, or has failed.
    pub chosen: Option<u8>,
    /// Resonances, by rising frequency.
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
    /// Number of the new session, which all further commands carry in their frames. Never
    /// [`NO_SESSION`](crate::board::link::NO_SESSION).
    pub session: u32,
}

/// Properties of a board's converters that no setting changes. The host converts codes and block
/// numbers with them.
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
    /// Returns the converters of a configuration.
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
    /// Returns the orders after this command; `None` if the command does not change them.
    pub fn applied_to(&self, orders: &Orders) -> Result<Option<Orders>, Refusal> {
        let mut next = Orders { sequence: orders.sequence.wrapping_add(1), clear_fault: false, ..*orders };
        match *self {
            Command::Identify(_) | Command::TelemetryEvery(_) | Command::Settings(_) | Command::Resonances => return Ok(None),
            Command::Status | Command::Capture(_) | Command::Faults(_) | Command::Reset | Command::Update(_) => return Ok(None),
            Command::Hardware | Command::Mute(_) => return Ok(None),
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
