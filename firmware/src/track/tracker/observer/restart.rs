//! Restarts of the filter from a measured current: after a step of the drive, in silence, and when
//! the gate opens because the load has jumped.

use super::{ARM_BLOCKS, Covariance, LEAK_REL, Observer, SILENT_SIGMAS, STEADY_VOLTAGE_REL, TAU};
use crate::seam::compare::larger;
use crate::seam::phasor::Phasor;

/// Innovation above which the gate opens, standard deviations.
const GATE_SIGMAS: f32 = 5.0;
/// Deviation of the resonance after the gate has opened, relative to the nominal frequency: 300 Hz
/// at 40 kHz.
const GATE_OPENS_REL: f32 = 300.0 / 40e3;

impl Observer {
    /// Begins with a measured current where the block before does not predict it: at an edge, or in
    /// silence.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(super) fn begin(&mut self, current: Phasor, before_v: Phasor) {
        let (now, before) = (self.voltage.norm_sqr(), before_v.norm_sqr());
        let per_square = self.nominal_strength.norm_sqr();
        let loudest = larger(now, before);
        let step = (self.voltage - before_v).norm_sqr();
        if loudest * per_square < self.noise && self.is_silent(current) {
            self.ringing.rest();
        } else if step > STEADY_VOLTAGE_REL * STEADY_VOLTAGE_REL * loudest {
            self.ringing.step(step);
        }
        self.jump(current, self.noise + self.ringing.variance() + LEAK_REL * LEAK_REL * per_square * now);
    }

    /// Returns `true` if a current without drive is only noise.
    #[inline]
    pub(super) fn is_silent(&self, current: Phasor) -> bool {
        current.norm_sqr() < SILENT_SIGMAS * SILENT_SIGMAS * self.noise
    }

    /// Restarts from a measured current, without a prediction. The pole is kept.
    #[inline(never)]
    pub(super) fn jump(&mut self, current: Phasor, variance: f32) {
        self.current = current;
        self.covariance = Covariance {
            current: variance,
            current_pole: Phasor::new(0.0, 0.0),
            current_strength: Phasor::new(0.0, 0.0),
            pole: self.covariance.pole + self.wander,
            ..self.covariance
        };
        self.rate = 0.0;
    }

    /// Returns `true` if the gate is armed and an innovation with this variance exceeds noise.
    #[inline]
    pub(super) fn exceeds_gate(&self, innovation: Phasor, variance: f32) -> bool {
        self.calm > ARM_BLOCKS && innovation.norm_sqr() > GATE_SIGMAS * GATE_SIGMAS * variance
    }

    /// Opens the gate.
    #[inline(never)]
    pub(super) fn open(&mut self, current: Phasor, noise: f32) {
        self.jump(current, 4.0 * noise);
        let spread = TAU * GATE_OPENS_REL * self.nominal_hz * self.block_s;
        self.covariance.pole = self.covariance.pole.max(spread * spread);
        self.covariance.pole_strength = Phasor::new(0.0, 0.0);
        self.calm = 0;
    }
}
