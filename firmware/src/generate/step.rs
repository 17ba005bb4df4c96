//! What a stage of the controller wants next, in one form for all of them, and what is played for it.

use crate::seam::block::Gate;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::seam::units::Turns;

/// The answer of a stage to one block.
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
        /// The lane that the sense channels are connected to.
        lane: u8,
    },
    /// The drive that follows the resonance, at the frequency that has been set already.
    Follow(Plan),
    /// The stage is over. A tone at the present frequency leads to the next one.
    Done {
        /// Peak voltage, V; zero is silence.
        volts: f32,
    },
    /// The stage cannot tell; silence, and another stage takes its place.
    Instead(Mode),
    /// The stage has failed; the drive is muted.
    Failed(Fault),
}

/// What is played in the next block, before the burst schedule limits it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Peak voltage before the envelope, V.
    pub volts: f32,
    /// When the drive is let through.
    pub(crate) gate: Gate,
    /// The lane that the sense channels are connected to.
    pub(crate) listen: u8,
    /// Offset of the tracked resonance from the nominal frequency, Hz; `None` where nothing is tracked.
    pub(crate) tracked_hz: Option<f32>,
    /// The phase that the tracker drives to zero.
    pub phase: Turns,
    /// The frequency window limits what the order asks for.
    pub(crate) limited: bool,
    /// How the stage is getting on.
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

    /// The plan for a step. `retune` sets the frequency, as an offset from the nominal one, Hz.
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

/// How a stage of the way to [`Mode::Run`] is getting on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The stage goes on.
    Busy,
    /// The stage is complete.
    Done,
    /// The controller has to go to this other stage.
    Back(Mode),
    /// The stage has failed with this fault.
    Failed(Fault),
}
