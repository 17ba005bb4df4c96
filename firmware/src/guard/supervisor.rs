//! The supervisor: may we drive, and what is limiting us?
//!
//! ```text
//! Idle -> SelfTest -> Scan | Clamped | Calibrate -> Lock -> Run
//!   ^        |          |        |          |      |
//!   |        +----------+--------+--+-------+------+--> Fault (sticky; the drive is muted)
//!   +--- order: Idle -------------------- order: clear ---+
//! ```
//!
//! An order to scan or to calibrate goes from anywhere to SelfTest, and from Scan or Calibrate back to Idle. A calibration that another order
//! ends has changed nothing.

use core::mem;

use crate::generate::step::Progress;
use crate::seam::block::{Orders, Request};
use crate::seam::config::TrackingMode;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;

/// How a run finds its frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Acquisition {
    /// At the nominal frequency.
    Nominal,
    /// At a resonance that a scan finds.
    Scanned,
    /// At the estimate of an observer, which needs the clamped branch.
    Observed,
}

impl Acquisition {
    /// What a mode of tracking begins with.
    pub(crate) fn of(mode: TrackingMode) -> Self {
        match mode {
            TrackingMode::Observer => Acquisition::Observed,
            TrackingMode::PhaseLock | TrackingMode::ZeroPhase => Acquisition::Scanned,
            TrackingMode::Off => Acquisition::Nominal,
        }
    }
}

/// The mode, the fault, and what the last order was.
#[derive(Clone, Debug)]
pub(crate) struct Supervisor {
    acquisition: Acquisition,
    mode: Mode,
    fault: Option<Fault>,
    /// The fault is new.
    raised: bool,
    obeyed: u32,
    /// The attempt that is done.
    done: Option<u32>,
}

impl Supervisor {
    /// Idle, for runs that come to their frequency in this way.
    pub(crate) fn new(acquisition: Acquisition) -> Self {
        Supervisor { acquisition, mode: Mode::Idle, fault: None, raised: false, obeyed: 0, done: None }
    }

    /// What the controller is doing.
    pub(crate) fn mode(&self) -> Mode {
        self.mode
    }

    /// Why the drive is muted.
    pub(crate) fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Whether a fault was raised since this was last asked for.
    #[inline]
    pub(crate) fn take_raised(&mut self) -> bool {
        mem::take(&mut self.raised)
    }

    /// Takes this block's order and what the guard has found. Returns whether a new attempt begins.
    // Not inlined: a block takes fewer instructions so, which `docs/evidence/instructions.md` counts.
    #[inline(never)]
    pub(crate) fn judge(&mut self, orders: &Orders, found: Option<Fault>) -> bool {
        let cleared = orders.clear_fault && orders.sequence != self.obeyed;
        self.obeyed = orders.sequence;
        if cleared && self.mode == Mode::Fault {
            self.fault = None;
            self.mode = Mode::Idle;
        }
        // Silence is judged too, except for what a muted drive cannot harm: a fault is only news while driving.
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
            // Both are done once for each order: the mode returns to idle, and only a new order repeats them.
            (Mode::Idle, Request::Scan | Request::Calibrate) if self.done == Some(orders.attempt) => false,
            // A new order of either also ends a run, and any other a calibration.
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

    /// Moves on when the present stage is over.
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

    /// The order is executed.
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
