//! The next step of a stage of the controller, in one form for all stages, and the plan for it.

use crate::seam::block::Gate;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::seam::units::Turns;

/// Answer of a stage to one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Silence. The frequency stays where it is.
    Silence,
    /// A tone for a measurement.
    Tone {
        /// Offset from the nominal frequency, Hz.
        offset_hz: f32,
        /// Peak voltage, V.
        volts: f32,
        /// Lane that the sense channels are connected to.
        lane: u8,
    },
    /// The drive that follows the resonance, at the frequency that has been set already.
    Follow(Plan),
    /// The stage is complete. A tone at the present frequency leads to the next one.
    Done {
        /// Peak voltage, V; zero is silence.
        volts: f32,
    },
    /// The stage cannot decide. The drive is silent, and another stage takes over.
    Instead(Mode),
    /// The stage has failed; the drive is muted.
    Failed(Fault),
}

/// Plan of the next block, before the burst schedule limits it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Peak voltage before the envelope, V.
    pub volts: f32,
    /// Gate of the drive.
    pub(crate) gate: Gate,
    /// Lane that the sense channels are connected to.
    pub(crate) listen: u8,
    /// Offset of the tracked resonance from the nominal frequency, Hz; `None` if nothing is
    /// tracked.
    pub(crate) tracked_hz: Option<f32>,
    /// Phase that the tracker drives to zero.
    pub phase: Turns,
    /// `true` if the frequency window limits the set point.
    pub(crate) limited: bool,
    /// Progress of the stage.
    pub(crate) progress: Progress,
}

impl Plan {
    const SILENT: Plan = Plan {
        volts: 0.0,
        gate: Gate::Off,
        listen: 0,
        tracked_hz: None,
        phase: Turns(0.0),
        limited: false,
        progress: Progress::Busy,
    };

    /// Creates the plan for a step. `retune` sets the frequency, as an offset from the nominal one,
    /// Hz.
    pub(crate) fn of(step: Step, retune: impl FnOnce(f32)) -> Self {
        match step {
            Step::Silence => Plan::SILENT,
            Step::Tone { offset_hz, volts, lane } => {
                retune(offset_hz);
                Plan { volts, gate: Gate::On, listen: lane, ..Plan::SILENT }
            }
            Step::Follow(plan) => plan,
            Step::Done { volts } => {
                let gate = if volts > 0.0 { Gate::On } else { Gate::Off };
                Plan { volts, gate, progress: Progress::Done, ..Plan::SILENT }
            }
            Step::Instead(mode) => Plan { progress: Progress::Back(mode), ..Plan::SILENT },
            Step::Failed(fault) => Plan { progress: Progress::Failed(fault), ..Plan::SILENT },
        }
    }
}

/// Progress of a stage on the way to [`Mode::Run`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The stage continues.
    Busy,
    /// The stage is complete.
    Done,
    /// The controller must go back to this other stage.
    Back(Mode),
    /// The stage has failed with this fault.
    Failed(Fault),
}
