//! Priors: the knowledge with which an observer begins.

use crate::seam::phasor::Phasor;

/// What is known before the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Offset from the nominal frequency, Hz, and how far off that may be.
    pub offset_hz: (f32, f32),
    /// Quality factor, within a factor of two.
    pub q: f32,
    /// Motional inductance, H, and its standard deviation.
    pub lm_h: (f32, f32),
    /// Direction of the motional admittance at resonance.
    pub axis: Phasor,
    /// Rms of a block's motional current by noise, A, both components.
    pub noise_a: f32,
}
