//! The supervisor: the state machine of the modes, and the fault that mutes the drive.
//!
//! ```text
//! Idle -> SelfTest -> Scan | Clamped | Calibrate -> Lock -> Run
//!   ^        |          |        |          |      |
//!   |        +----------+--------+--+-------+------+--> Fault (sticky; the drive is muted)
//!   +--- order: Idle -------------------- order: clear ---+
//! ```
//!
//! An order to scan or to calibrate leads to `SelfTest` from every other mode except `Fault`; a
//! complete `Scan` or `Calibrate` leads back to `Idle`. If another order ends a calibration, the
//! trims remain unchanged.

use core::mem;

use crate::generate::step::Progress;
use crate::seam::block::{Orders, Request};
use crate::seam::config::TrackingMode;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;

/// Start of a run: the source of its first frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Acquisition {
    /// The nominal frequency.
    Nominal,
    /// A resonance found by a scan.
    Scanned,
    /// The estimate of the observer, which needs the clamped branch.
    Observed,
}

impl Acquisition {
    /// Returns the acquisition that a mode of tracking needs.
    pub(crate) fn from_tracking(mode: TrackingMode) -> Self {
        match mode {
            TrackingMode::Observer => Acquisition::Observed,
            TrackingMode::PhaseLock | TrackingMode::ZeroPhase => Acquisition::Scanned,
            TrackingMode::Off => Acquisition::Nominal,
        }
    }
}

/// The state machine: mode, fault, and the last order.
#[derive(Clone, Debug)]
pub(crate) struct Supervisor {
    acquisition: Acquisition,
    mode: Mode,
    fault: Option<Fault>,
    /// `true` if a fault was raised since the last [`take_raised`](Self::take_raised).
    raised: bool,
    /// Sequence number of the last order.
    obeyed: u32,
    /// Number of the last scan or calibration attempt that is complete.
    done: Option<u32>,
}

impl Supervisor {
    /// Creates a supervisor in `Idle`, whose runs start with `acquisition`.
    pub(crate) fn new(acquisition: Acquisition) -> Self {
        Supervisor { acquisition, mode: Mode::Idle, fault: None, raised: false, obeyed: 0, done: None }
    }

    /// Returns the present mode.
    pub(crate) fn mode(&self) -> Mode {
        self.mode
    }

    /// Returns the fault for which the drive is muted.
    pub(crate) fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Returns `true` if a fault was raised since the last call.
    #[inline]
    pub(crate) fn take_raised(&mut self) -> bool {
        mem::take(&mut self.raised)
    }

    /// Applies the orders of this block and the fault found in it. Returns `true` if a new attempt
    /// begins.
    // Not inlined: this takes fewer instructions a block (`docs/evidence/instructions.md`).
    #[inline(never)]
    pub(crate) fn judge(&mut self, orders: &Orders, found: Option<Fault>) -> bool {
        let cleared = orders.clear_fault && orders.sequence != self.obeyed;
        self.obeyed = orders.sequence;
        if cleared && self.mode == Mode::Fault {
            self.fault = None;
            self.mode = Mode::Idle;
        }
        // A fault found in silence is ignored, because a muted drive cannot do harm.
        // Emergency stop and host loss count in every mode.
        let driving = !matches!(self.mode, Mode::Idle | Mode::Fault);
        if orders.emergency_stop {
            self.raise(Fault::EmergencyStop);
        } else if orders.host_lost {
            self.raise(Fault::HostLost);
        } else if let Some(fault) = found.filter(|_| driving) {
            self.raise(fault);
        }
        match (self.mode, orders.request) {
            (Mode::Fault, _) => false,
            (_, Request::Idle) => {
                self.mode = Mode::Idle;
                false
            }
            // A scan or calibration is done once for each attempt; then the mode stays `Idle`.
            (Mode::Idle, Request::Scan | Request::Calibrate) if self.done == Some(orders.attempt) => false,
            // A new scan or calibration ends a run; every other order ends a calibration.
            (Mode::Idle, _)
            | (Mode::Lock | Mode::Run, Request::Scan | Request::Calibrate)
            | (Mode::Scan | Mode::Clamped, Request::Calibrate)
            | (Mode::Clamped, Request::Scan)
            | (Mode::Calibrate, Request::Scan | Request::Run) => {
                self.mode = Mode::SelfTest;
                true
            }
            _ => false,
        }
    }

    /// Advances the mode if the present stage is complete, failed, or goes back.
    pub(crate) fn advance(&mut self, orders: &Orders, progress: Progress) {
        match progress {
            Progress::Busy => {}
            Progress::Failed(fault) => self.raise(fault),
            Progress::Back(mode) => self.mode = mode,
            Progress::Done => {
                self.mode = match self.mode {
                    Mode::SelfTest if orders.request == Request::Calibrate => Mode::Calibrate,
                    Mode::SelfTest if orders.request == Request::Scan => Mode::Scan,
                    Mode::SelfTest => match self.acquisition {
                        Acquisition::Nominal => Mode::Run,
                        Acquisition::Scanned => Mode::Scan,
                        Acquisition::Observed => Mode::Clamped,
                    },
                    Mode::Clamped => Mode::Lock,
                    Mode::Calibrate => self.end(orders),
                    Mode::Scan if orders.request == Request::Scan => self.end(orders),
                    Mode::Scan => Mode::Lock,
                    Mode::Lock => Mode::Run,
                    other => other,
                }
            }
        }
    }

    /// Marks the attempt as complete and returns `Idle`.
    fn end(&mut self, orders: &Orders) -> Mode {
        self.done = Some(orders.attempt);
        Mode::Idle
    }

    fn raise(&mut self, fault: Fault) {
        if self.mode != Mode::Fault {
            self.fault = Some(fault);
            self.raised = true;
            self.mode = Mode::Fault;
        }
    }
}

#[cfg(test)]
mod tests;
