//! Description of a transducer: equivalent circuit, deviations, and other resonances.

use serde::{Deserialize, Serialize};

use crate::seam::compare::larger;

const TAU: f32 = core::f32::consts::TAU;

/// Largest number of listed resonances.
pub const MOST_MODES: usize = 4;

/// Equivalent circuit of a transducer, as identified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transducer {
    /// Series (motional) resonance, Hz.
    pub series_resonance_hz: f32,
    /// Parallel resonance (antiresonance), Hz.
    pub parallel_resonance_hz: f32,
    /// Quality factor at series resonance.
    pub q: f32,
    /// Motional resistance, ohm.
    pub rm_ohm: f32,
    /// Motional inductance, H.
    pub lm_h: f32,
    /// Motional capacitance, F.
    pub cm_f: f32,
    /// Clamped capacitance, F; includes the apparent part by DAC images.
    pub c0_f: f32,
    /// Effective coupling, `sqrt(Cm / (C0 + Cm))`.
    pub coupling: f32,
    /// Standard deviations of these values.
    pub deviations: Deviations,
    /// Quality of the lock on this resonance.
    pub quality: LockQuality,
    /// Number of resonances found.
    pub modes: u8,
    /// Index of this resonance in the list of those found, from zero.
    pub chosen: u8,
}

impl Transducer {
    /// Returns the ring-up time constant `Q / (pi fs)`, s.
    pub fn time_constant_s(&self) -> f32 {
        2.0 * self.q / (TAU * self.series_resonance_hz)
    }

    /// Copies `from` field by field: the compiler moves the whole with a call, which takes three
    /// times as long.
    #[inline]
    pub(crate) fn copy(&mut self, from: &Transducer) {
        self.series_resonance_hz = from.series_resonance_hz;
        self.parallel_resonance_hz = from.parallel_resonance_hz;
        self.q = from.q;
        self.rm_ohm = from.rm_ohm;
        self.lm_h = from.lm_h;
        self.cm_f = from.cm_f;
        self.c0_f = from.c0_f;
        self.coupling = from.coupling;
        self.deviations = from.deviations;
        self.quality = from.quality;
        (self.modes, self.chosen) = (from.modes, from.chosen);
    }
}

/// Standard deviations of the identified values, from the measured noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Deviations {
    /// Standard deviation of the series resonance, Hz.
    pub series_resonance_hz: f32,
    /// Standard deviation of the parallel resonance, Hz.
    pub parallel_resonance_hz: f32,
    /// Standard deviation of the quality factor.
    pub q: f32,
    /// Standard deviation of the motional resistance, ohm.
    pub rm_ohm: f32,
    /// Standard deviation of the motional inductance, H.
    pub lm_h: f32,
    /// Standard deviation of the motional capacitance, F.
    pub cm_f: f32,
    /// Standard deviation of the clamped capacitance, F.
    pub c0_f: f32,
    /// Standard deviation of the coupling.
    pub coupling: f32,
}

/// Rms residual, relative to the expected one, beyond which a model does not fit. The contact
/// of a rotor takes it to 23.
const MAX_MISFIT: f32 = 30.0;

/// Quality of a lock, as limited by other resonances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LockQuality {
    /// Loss of tip velocity per volt, relative to its maximum nearby, that the measurements do not
    /// exclude; one if the model does not fit, or if the other resonances outweigh this one.
    pub loss: f32,
    /// Admittance of the other resonances at the lock point, relative to the motional conductance.
    pub others: f32,
    /// Rms residual of the fitted model, relative to the expected one: the noise of the converters,
    /// and 3e-4 of the largest line of a scan.
    pub misfit: f32,
}

impl LockQuality {
    /// Largest loss of tip velocity that is not reported.
    pub(crate) const MAX_LOSS: f32 = 0.01;

    /// Returns the quality of a lock whose motional phase is off by an angle with this tangent.
    pub(crate) fn new(tangent: f32, others: f32, misfit: f32) -> Self {
        let mut quality = LockQuality { loss: 0.0, others, misfit };
        quality.turn(tangent);
        if misfit > MAX_MISFIT || others > 1.0 {
            quality.loss = 1.0;
        }
        quality
    }

    /// Raises the loss to `1 - 1 / sqrt(1 + x^2)`, that of a motional phase with the tangent `x`.
    pub(crate) fn turn(&mut self, tangent: f32) {
        let square = tangent * tangent;
        let root = fpu::sqrtf(1.0 + square);
        self.loss = larger(self.loss, square / (root * (root + 1.0)));
    }

    /// Returns `true` if the drive may lose more tip velocity than is acceptable.
    #[inline]
    pub(crate) fn is_lossy(&self) -> bool {
        self.loss > Self::MAX_LOSS
    }
}

/// Resonance found by a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Resonance {
    /// Series resonance of this mode, Hz.
    pub hz: f32,
    /// Quality factor of this mode.
    pub q: f32,
    /// Motional inductance of this mode, H.
    pub lm_h: f32,
    /// Motional conductance at the resonance, S.
    pub conductance_s: f32,
}

/// Item of a list of resonances; the telemetry of a block carries one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Listed {
    /// Index of this resonance in the list, from zero.
    pub place: u8,
    /// Number of resonances in the list.
    pub of: u8,
    /// The resonance itself.
    pub resonance: Resonance,
}

/// Resonances found by a scan, at rising frequencies.
pub type Resonances = heapless::Vec<Resonance, MOST_MODES>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loss_follows_from_the_phase_unless_the_model_does_not_fit() {
        // Seven hundredths of a bandwidth lose one percent.
        for (tangent, loss, is_lossy) in
            [(0.0, 0.0, false), (0.14, 0.009_66, false), (0.143, 0.010_07, true), (1.0, 0.292_89, true)]
        {
            let quality = LockQuality::new(tangent, 0.9, 19.0);
            assert!((quality.loss - loss).abs() < 1e-5, "{quality:?}");
            assert_eq!(quality.is_lossy(), is_lossy, "{quality:?}");
        }
        assert!(LockQuality::new(0.0, 1.1, 1.0).is_lossy() && LockQuality::new(0.0, 0.0, 31.0).is_lossy());
        let mut quality = LockQuality::new(0.14, 0.0, 1.0);
        quality.turn(0.01);
        assert_eq!(quality, LockQuality::new(0.14, 0.0, 1.0), "a later measurement does not lower the loss");
    }
}
