//! Prior of the observer.

use crate::seam::phasor::Phasor;

/// Knowledge of the resonance before the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Offset from the nominal frequency, and its standard deviation, Hz.
    pub offset_hz: (f32, f32),
    /// Quality factor, known to a factor of two.
    pub q: f32,
    /// Motional inductance, and its standard deviation, H.
    pub lm_h: (f32, f32),
    /// Direction of the motional admittance at resonance.
    pub axis: Phasor,
    /// Rms noise of a block's motional current, A, of both components together.
    pub noise_a: f32,
}
