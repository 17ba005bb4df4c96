//! The circuit that a fit assumes and finds: a clamped branch and some resonances (Butterworth 1914, Van Dyke 1928), and what is left of a record
//! without them.

use heapless::Vec;

use crate::seam::phasor::{Phasor, direction, magnitude};
use crate::seam::transducer::{MOST_MODES, Transducer};
use crate::sense::motional::Motional;

const TAU: f32 = core::f32::consts::TAU;
const J: Phasor = Phasor::new(0.0, 1.0);
const ONE: Phasor = Phasor::new(1.0, 0.0);
const NONE: Phasor = Phasor::new(0.0, 0.0);

/// One resonance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pole {
    /// Series resonance, as an offset from the nominal frequency, Hz.
    pub offset_hz: f32,
    /// Quality factor of the resonance.
    pub q: f32,
    /// Admittance at the series resonance, S.
    pub(crate) conductance: Phasor,
    /// Free vibration, at the same place, A.
    pub(crate) transient: Phasor,
}

impl Pole {
    /// `G / Q`, which does not depend on how much a resonance is damped.
    pub(crate) fn strength(&self) -> f32 {
        magnitude(self.conductance) / self.q
    }
}

/// All resonances, and what is left without them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Circuit {
    /// Middle of the window, Hz.
    pub(crate) nominal_hz: f32,
    /// The resonances.
    pub(crate) poles: Vec<Pole, MOST_MODES>,
    /// Resonances that are known from elsewhere: none of these is fitted, nor do they ring by themselves.
    pub(crate) known: Vec<Pole, MOST_MODES>,
    /// Admittance of the clamped branch at the nominal frequency, S; its susceptance rises with frequency.
    pub y0: Phasor,
    /// Clamped capacitance by which it rises, F.
    pub c0_f: f32,
    /// Current that the circuit does not explain, A.
    pub(crate) rest: Phasor,
}

impl Circuit {
    /// A bare capacitance.
    pub(crate) fn bare(nominal_hz: f32, c0_f: f32) -> Self {
        Circuit { nominal_hz, c0_f, y0: J * (TAU * nominal_hz * c0_f), ..Circuit::default() }
    }

    /// The current in a line of the record that this was found in.
    pub(crate) fn current(&self, offset_hz: f32, v: Phasor) -> Phasor {
        let poles: Phasor =
            self.poles.iter().map(|pole| (pole.conductance * v + pole.transient) * self.phi(pole, offset_hz)).sum();
        (self.y0 + self.fixed(offset_hz)) * v + self.rest + poles
    }

    /// What the other resonances that were fitted add to the admittance at the place of one, S.
    pub(super) fn beside(&self, which: usize) -> Phasor {
        let Some(at) = self.poles.get(which) else { return NONE };
        let others = self.poles.iter().enumerate().filter(|(n, _)| *n != which);
        others.map(|(_, pole)| pole.conductance * self.phi(pole, at.offset_hz)).sum()
    }

    /// The circuit of one resonance, without its deviations.
    pub(crate) fn transducer(&self, which: usize) -> Transducer {
        let Some(&Pole { offset_hz, q, conductance, .. }) = self.poles.get(which) else { return Transducer::default() };
        let hz = self.nominal_hz + offset_hz;
        let rm_ohm = 1.0 / magnitude(conductance);
        let lm_h = q * rm_ohm / (TAU * hz);
        let cm_f = 1.0 / (TAU * hz * q * rm_ohm);
        let c0_f = (self.y0 + self.slope(offset_hz)).im / (TAU * hz);
        Transducer {
            series_resonance_hz: hz,
            parallel_resonance_hz: hz * libm::sqrtf(1.0 + cm_f / c0_f),
            q,
            rm_ohm,
            lm_h,
            cm_f,
            c0_f,
            coupling: libm::sqrtf(cm_f / (c0_f + cm_f)),
            ..Transducer::default()
        }
    }

    /// One resonance for tracking: what others add to the admittance there belongs to the clamped branch.
    pub(crate) fn motional(&self, which: usize) -> Motional {
        let Some(pole) = self.poles.get(which) else { return Motional { y0: self.y0, axis: ONE } };
        let there = self.y0 + self.fixed(pole.offset_hz) + self.beside(which);
        let relative = (self.nominal_hz + pole.offset_hz) / self.nominal_hz;
        Motional { y0: Phasor::new(there.re, there.im / relative), axis: direction(pole.conductance) }
    }

    /// How what the other resonances add at the place of one changes with the frequency there, S/Hz: `d/df G / (1 + j Q w) = -j 2 Q / f0 G / (1 + j Q w)^2`, nearly.
    pub(crate) fn slope_beside(&self, which: usize) -> Phasor {
        let Some(at) = self.poles.get(which) else { return NONE };
        let others = self.poles.iter().enumerate().filter(|(n, _)| *n != which).map(|(_, pole)| pole).chain(&self.known);
        let slope = |pole: &Pole| {
            let phi = self.phi(pole, at.offset_hz);
            pole.conductance * phi * phi * Phasor::new(0.0, -2.0 * pole.q / (self.nominal_hz + pole.offset_hz))
        };
        others.map(slope).sum()
    }

    /// What the clamped capacitance takes more at this offset than at the nominal frequency, S.
    fn slope(&self, offset_hz: f32) -> Phasor {
        J * (TAU * self.c0_f * offset_hz)
    }

    /// What is not fitted at this offset, S.
    pub(super) fn fixed(&self, offset_hz: f32) -> Phasor {
        let known: Phasor = self.known.iter().map(|pole| pole.conductance * self.phi(pole, offset_hz)).sum();
        self.slope(offset_hz) + known
    }

    /// How much a pole answers at an offset.
    pub(super) fn phi(&self, pole: &Pole, offset_hz: f32) -> Phasor {
        self.answer(pole, Phasor::new(offset_hz, 0.0))
    }

    /// The same at a complex frequency.
    pub(super) fn answer(&self, pole: &Pole, offset_hz: Phasor) -> Phasor {
        let ratio = (offset_hz - pole.offset_hz) / (self.nominal_hz + pole.offset_hz);
        let detuning = if ratio.im == 0.0 {
            Phasor::new(ratio.re * (2.0 + ratio.re) / (1.0 + ratio.re), 0.0)
        } else {
            ratio * (ratio + 2.0) / (ratio + 1.0)
        };
        (ONE + J * detuning * pole.q).inv()
    }

    /// The complex frequency at which the detuning of a pole is `w`, as an offset from the nominal one, Hz.
    pub(super) fn complex_hz(&self, pole: &Pole, w: Phasor) -> Phasor {
        let half = w * 0.5;
        (half + half * half * 0.5) * (self.nominal_hz + pole.offset_hz) + pole.offset_hz
    }
}
