//! Equivalent circuit of a fit: a clamped branch and several resonances (Butterworth 1914, Van Dyke
//! 1928), and the part of the record that they do not explain.

use heapless::Vec;

use crate::seam::phasor::{Phasor, direction, magnitude};
use crate::seam::transducer::{MOST_MODES, Transducer};
use crate::sense::motional::Motional;

const TAU: f32 = core::f32::consts::TAU;
const J: Phasor = Phasor::new(0.0, 1.0);
const ONE: Phasor = Phasor::new(1.0, 0.0);
const ZERO: Phasor = Phasor::new(0.0, 0.0);

/// One resonance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pole {
    /// Series resonance frequency, as an offset from the nominal frequency, Hz.
    pub offset_hz: f32,
    /// Quality factor of the resonance.
    pub q: f32,
    /// Admittance at the series resonance, S.
    pub(crate) conductance: Phasor,
    /// Free vibration at the series resonance, A.
    pub(crate) transient: Phasor,
}

impl Pole {
    /// Returns `G / Q`, which does not depend on the damping.
    pub(crate) fn strength(&self) -> f32 {
        magnitude(self.conductance) / self.q
    }
}

/// Clamped branch, all resonances, and the residual current.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Circuit {
    /// Middle of the window, Hz.
    pub(crate) nominal_hz: f32,
    /// Fitted resonances.
    pub(crate) poles: Vec<Pole, MOST_MODES>,
    /// Resonances known from elsewhere; they are not fitted and have no free vibration.
    pub(crate) known: Vec<Pole, MOST_MODES>,
    /// Admittance of the clamped branch at the nominal frequency, S; its susceptance rises with
    /// frequency.
    pub y0: Phasor,
    /// Clamped capacitance, the slope of that susceptance, F.
    pub c0_f: f32,
    /// Current that the circuit does not explain, A.
    pub(crate) rest: Phasor,
}

impl Circuit {
    /// Creates a circuit that is only a capacitance.
    pub(crate) fn bare(nominal_hz: f32, c0_f: f32) -> Self {
        Circuit { nominal_hz, c0_f, y0: J * (TAU * nominal_hz * c0_f), ..Circuit::default() }
    }

    /// Computes the current in a line of the record that this circuit was fitted to.
    pub(crate) fn current(&self, offset_hz: f32, v: Phasor) -> Phasor {
        let poles: Phasor =
            self.poles.iter().map(|pole| (pole.conductance * v + pole.transient) * self.phi(pole, offset_hz)).sum();
        (self.y0 + self.fixed(offset_hz)) * v + self.rest + poles
    }

    /// Computes the admittance of the other fitted resonances at the frequency of one, S.
    pub(super) fn others_admittance(&self, which: usize) -> Phasor {
        let Some(at) = self.poles.get(which) else { return ZERO };
        let others = self.poles.iter().enumerate().filter(|(n, _)| *n != which);
        others.map(|(_, pole)| pole.conductance * self.phi(pole, at.offset_hz)).sum()
    }

    /// Computes the admittance of all other resonances at the frequency of one, relative to the
    /// conductance of that one.
    pub(super) fn others_share(&self, which: usize) -> f32 {
        let Some(at) = self.poles.get(which) else { return 0.0 };
        let known = self.fixed(at.offset_hz) - self.slope(at.offset_hz);
        magnitude(self.others_admittance(which) + known) / magnitude(at.conductance)
    }

    /// Computes the equivalent circuit of one resonance, without standard deviations.
    pub(crate) fn transducer(&self, which: usize) -> Transducer {
        let Some(&Pole { offset_hz, q, conductance, .. }) = self.poles.get(which) else { return Transducer::default() };
        let hz = self.nominal_hz + offset_hz;
        let rm_ohm = 1.0 / magnitude(conductance);
        let lm_h = q * rm_ohm / (TAU * hz);
        let cm_f = 1.0 / (TAU * hz * q * rm_ohm);
        let c0_f = (self.y0 + self.slope(offset_hz)).im / (TAU * hz);
        Transducer {
            series_resonance_hz: hz,
            parallel_resonance_hz: hz * fpu::sqrtf(1.0 + cm_f / c0_f),
            q,
            rm_ohm,
            lm_h,
            cm_f,
            c0_f,
            coupling: fpu::sqrtf(cm_f / (c0_f + cm_f)),
            ..Transducer::default()
        }
    }

    /// Returns one resonance for tracking. The admittance of the others there is added to the
    /// clamped branch.
    pub(crate) fn motional(&self, which: usize) -> Motional {
        let Some(pole) = self.poles.get(which) else { return Motional { y0: self.y0, axis: ONE } };
        let there = self.y0 + self.fixed(pole.offset_hz) + self.others_admittance(which);
        let relative = (self.nominal_hz + pole.offset_hz) / self.nominal_hz;
        Motional { y0: Phasor::new(there.re, there.im / relative), axis: direction(pole.conductance) }
    }

    /// Computes the slope with frequency of the admittance of the other resonances, at one
    /// resonance, S/Hz: approximately `d/df G / (1 + j Q w) = -j 2 Q / f0 G / (1 + j Q w)^2`.
    pub(crate) fn others_slope(&self, which: usize) -> Phasor {
        let Some(at) = self.poles.get(which) else { return ZERO };
        let others = self.poles.iter().enumerate().filter(|(n, _)| *n != which).map(|(_, pole)| pole).chain(&self.known);
        let slope = |pole: &Pole| {
            let phi = self.phi(pole, at.offset_hz);
            pole.conductance * phi * phi * Phasor::new(0.0, -2.0 * pole.q / (self.nominal_hz + pole.offset_hz))
        };
        others.map(slope).sum()
    }

    /// Computes the difference of the clamped admittance to that at the nominal frequency, S.
    fn slope(&self, offset_hz: f32) -> Phasor {
        J * (TAU * self.c0_f * offset_hz)
    }

    /// Computes the admittance at this offset that is not fitted, S.
    pub(super) fn fixed(&self, offset_hz: f32) -> Phasor {
        let known: Phasor = self.known.iter().map(|pole| pole.conductance * self.phi(pole, offset_hz)).sum();
        self.slope(offset_hz) + known
    }

    /// Computes the normalised response of a pole at an offset.
    pub(super) fn phi(&self, pole: &Pole, offset_hz: f32) -> Phasor {
        self.response(pole, Phasor::new(offset_hz, 0.0))
    }

    /// Computes the normalised response of a pole at a complex frequency.
    pub(super) fn response(&self, pole: &Pole, offset_hz: Phasor) -> Phasor {
        let ratio = (offset_hz - pole.offset_hz) / (self.nominal_hz + pole.offset_hz);
        let detuning = if ratio.im == 0.0 {
            Phasor::new(ratio.re * (2.0 + ratio.re) / (1.0 + ratio.re), 0.0)
        } else {
            ratio * (ratio + 2.0) / (ratio + 1.0)
        };
        (ONE + J * detuning * pole.q).inv()
    }

    /// Computes the complex frequency at which the detuning of a pole is `w`, as an offset from the
    /// nominal frequency, Hz.
    pub(super) fn complex_hz(&self, pole: &Pole, w: Phasor) -> Phasor {
        let half = w * 0.5;
        (half + half * half * 0.5) * (self.nominal_hz + pole.offset_hz) + pole.offset_hz
    }
}
