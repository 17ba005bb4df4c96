//! Phasors to frequency: keeps the drive at the resonance while it moves.
//!
//! [`phase_loop`] is a proportional-integral loop on a phase that is zero at the resonance, normalised by Q; which phase, is
//! the [`PhaseDetector`]'s choice. [`lock_detector`] says whether to believe it.

pub mod lock_detector;
pub mod phase_loop;

use crate::config::TrackingMode;
use crate::demod::Sensed;
use crate::motional::Motional;
use crate::phasor::Phasor;

/// Which phase is driven to zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhaseDetector {
    /// Of the motional current: zero at the series resonance, at any load.
    Motional,
    /// Of the total current: the plain V-I loop. Biased by C0 (76 Hz at Q 65), and without any zero below M = 2.
    Total,
}

impl PhaseDetector {
    /// The detector of a tracking mode; `None` where nothing is tracked.
    pub fn of(mode: TrackingMode) -> Option<Self> {
        match mode {
            TrackingMode::PhaseLock => Some(PhaseDetector::Motional),
            TrackingMode::ZeroPhase => Some(PhaseDetector::Total),
            TrackingMode::Off => None,
        }
    }

    /// A phasor whose argument is the phase to be driven to zero.
    pub fn error(self, motional: &Motional, motional_current: Phasor, sensed: &Sensed) -> Phasor {
        match self {
            PhaseDetector::Motional => motional.phase_of(motional_current, sensed.v),
            PhaseDetector::Total => motional.phase_of(sensed.i, sensed.v),
        }
    }
}
