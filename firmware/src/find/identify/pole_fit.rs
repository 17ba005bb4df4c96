//! Resonances from the spectrum of a record that may contain transients.
//!
//! Voltage and current of a Butterworth-Van Dyke circuit with several motional branches obey, at
//! each line `f` of a [spectrum](crate::find::scan::spectrum),
//!
//! ```text
//! I = Y0 V + T0 + sum (G V + T) phi(f),    phi(f) = 1 / (1 + j Q (f / fs - fs / f))
//! ```
//!
//! The terms `T` are the free vibration at the beginning and at the end of the record. For a
//! rational system they have exactly this form, for any history and any truncation (R. Pintelon,
//! J. Schoukens and G. Vandersteen 1997). The record therefore needs no settling time. With assumed
//! poles, and with the unknown `s` for the error of each,
//!
//! ```text
//! I = Y0 V + T0 + sum (G V + T - s I) phi(f)
//! ```
//!
//! is linear. The poles are moved to the zeros of `1 + sum s phi` until they converge
//! (B. Gustavsen and A. Semlyen 1999; for one pole this is C. K. Sanathanan and J. Koerner 1963).
//! Each row is divided by the noise of `I - Y V`.
//!
//! The fitted `G` is complex: its argument is the phase shift of the sensing chain and becomes the
//! axis of the motional phase. The fitted `Y0` is as measured by the converters. Valid for
//! resonances inside the spectrum with Q above about five.

use crate::find::givens::ComplexTriangle;
pub(crate) use crate::find::identify::circuit::{Circuit, Pole};
use crate::find::identify::scatter::{Products, Scatter};
use crate::seam::phasor::Phasor;
use crate::seam::transducer::{MOST_MODES, Transducer};
use crate::sense::demod::Sensed;

const TAU: f32 = core::f32::consts::TAU;
const J: Phasor = Phasor::new(0.0, 1.0);
const ONE: Phasor = Phasor::new(1.0, 0.0);
const ZERO: Phasor = Phasor::new(0.0, 0.0);

/// Number of unknowns of the clamped branch.
const CLAMPED_UNKNOWNS: usize = 2;
/// Number of unknowns per resonance.
const POLE_UNKNOWNS: usize = 3;
/// Maximum number of unknowns.
const MAX_UNKNOWNS: usize = CLAMPED_UNKNOWNS + POLE_UNKNOWNS * MOST_MODES;
/// Rotations per block: those of a row with one resonance.
const ROTATIONS_PER_BLOCK: usize = 20;
/// Steps per iteration towards the zeros of `1 + sum s phi`; the next iteration continues from
/// there.
const ZERO_STEPS: usize = 4;

/// Pole fit in progress.
#[derive(Clone, Debug)]
pub(crate) struct PoleFit {
    assumed: Circuit,
    /// Noise of the voltage divided by the noise of the current, ohm.
    noise_ohm: f32,
    triangle: ComplexTriangle<MAX_UNKNOWNS>,
    /// Solution of the linear system.
    unknowns: [Phasor; MAX_UNKNOWNS],
    zeros: [Phasor; MOST_MODES],
    determined: bool,
    /// Number of completed parts of the solution.
    solved: usize,
    /// Errors of the resonance whose standard deviations are being computed.
    scatter: Scatter<MAX_UNKNOWNS>,
    products: Products,
    /// Number of completed parts of the standard deviations.
    scattered: usize,
    /// Circuit of that resonance, with its standard deviations.
    stated: Transducer,
}

/// Solution of a fit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Solution {
    /// Fitted circuit.
    pub(crate) circuit: Circuit,
    /// Largest displacement of a pole, in parts of its width.
    pub(crate) moved: f32,
}

/// Returns the unknowns `G`, `T` and `s` of each resonance.
fn pole_unknowns(unknowns: &[Phasor; MAX_UNKNOWNS]) -> &[[Phasor; POLE_UNKNOWNS]] {
    unknowns[CLAMPED_UNKNOWNS..].as_chunks().0
}

impl PoleFit {
    /// Creates an empty fit around an assumed circuit. `noise_ohm` is the noise of the voltage
    /// divided by that of the current: the ratio of their steps if both converters are of the same
    /// type.
    pub(crate) fn new(assumed: Circuit, noise_ohm: f32) -> Self {
        let unknowns = CLAMPED_UNKNOWNS + POLE_UNKNOWNS * assumed.poles.len();
        PoleFit {
            assumed,
            noise_ohm,
            triangle: ComplexTriangle::new(unknowns),
            unknowns: [ZERO; MAX_UNKNOWNS],
            zeros: [ZERO; MOST_MODES],
            determined: false,
            solved: 0,
            scatter: Scatter { pole: [ZERO; MAX_UNKNOWNS], strength: [ZERO; MAX_UNKNOWNS], y0: [ZERO; MAX_UNKNOWNS] },
            products: Products::default(),
            scattered: 0,
            stated: Transducer::default(),
        }
    }

    /// Starts again around another assumed circuit.
    pub(crate) fn restart(&mut self, assumed: &Circuit) {
        self.assumed.clone_from(assumed);
        self.triangle.restart(CLAMPED_UNKNOWNS + POLE_UNKNOWNS * assumed.poles.len());
        (self.solved, self.scattered) = (0, 0);
    }

    /// Adds part of a line, as much as fits into a block. Returns `true` if the line is complete.
    pub(crate) fn add(&mut self, offset_hz: f32, line: &Sensed) -> bool {
        if self.triangle.is_idle() {
            self.begin(offset_hz, line);
        }
        self.triangle.fold(ROTATIONS_PER_BLOCK)
    }

    fn begin(&mut self, offset_hz: f32, line: &Sensed) {
        let circuit = &self.assumed;
        let fixed = circuit.fixed(offset_hz);
        let mut y = circuit.y0 + fixed;
        let mut phis = [ZERO; MOST_MODES];
        for (phi, pole) in phis.iter_mut().zip(&circuit.poles) {
            *phi = circuit.phi(pole, offset_hz);
            y += pole.conductance * *phi;
        }
        let weight = 1.0 / fpu::sqrtf(1.0 + self.noise_ohm * self.noise_ohm * y.norm_sqr());
        let (v, i) = (line.v * weight, (line.i - line.v * fixed) * weight);
        let mut row = [ZERO; MAX_UNKNOWNS];
        (row[0], row[1]) = (v, ONE * weight);
        for (columns, phi) in row[CLAMPED_UNKNOWNS..].chunks_exact_mut(POLE_UNKNOWNS).zip(&phis).take(circuit.poles.len()) {
            columns.copy_from_slice(&[v * phi, phi * weight, -i * phi]);
        }
        self.triangle.add(row, i);
    }

    /// Does the part of the solution that fits into a block. Returns `true` if the
    /// [solution](Self::solution) is complete or does not exist.
    pub(crate) fn solve(&mut self) -> bool {
        if self.solved == 0 {
            self.solved = 1;
            let unknowns = self.triangle.solve();
            self.determined = unknowns.is_some();
            self.begin_zeros(unknowns.unwrap_or_default());
            return !self.determined;
        }
        // A block has time for all steps only if there is at most one resonance.
        let steps = if self.assumed.poles.len() > 1 { 1 } else { ZERO_STEPS };
        if self.solved <= ZERO_STEPS {
            (0..steps).for_each(|_| self.move_zeros());
            self.solved += steps;
        }
        self.solved > ZERO_STEPS
    }

    fn begin_zeros(&mut self, unknowns: [Phasor; MAX_UNKNOWNS]) {
        self.unknowns = unknowns;
        for (zero, pole) in self.zeros.iter_mut().zip(&self.assumed.poles) {
            *zero = self.assumed.complex_hz(pole, J / pole.q);
        }
    }

    /// Moves the zeros by one step.
    fn move_zeros(&mut self) {
        let (assumed, unknowns) = (&self.assumed, &self.unknowns);
        let solved = pole_unknowns(unknowns);
        for (n, ((zero, pole), [_, _, s])) in self.zeros.iter_mut().zip(&assumed.poles).zip(solved).enumerate() {
            let others = assumed.poles.iter().zip(solved).enumerate().filter(|(k, _)| *k != n);
            let rest: Phasor = others.map(|(_, (other, [_, _, s]))| *s * assumed.response(other, *zero)).sum();
            // 1 + j Q w = -s / (1 + others), hence w.
            let w = J * (ONE + *s / (ONE + rest)) / pole.q;
            *zero = assumed.complex_hz(pole, w);
        }
    }

    /// Returns the fitted circuit; `None` if the lines do not determine it or if it is implausible.
    pub(crate) fn solution(&self) -> Option<Solution> {
        if !self.determined {
            return None;
        }
        let (assumed, unknowns) = (&self.assumed, &self.unknowns);
        let mut circuit = assumed.clone();
        (circuit.y0, circuit.rest) = (unknowns[0], unknowns[1]);
        let solved = pole_unknowns(unknowns).iter().zip(&self.zeros);
        let mut moved: f32 = 0.0;
        for (((n, pole), new), (&[strength, transient, s], &zero)) in
            assumed.poles.iter().enumerate().zip(&mut circuit.poles).zip(solved)
        {
            // The magnitude of the pole is the resonance. A growing solution is read as decaying.
            let damping_hz = zero.im.abs();
            let offset_hz = zero.re + 0.5 * damping_hz * damping_hz / (assumed.nominal_hz + zero.re);
            let hz = assumed.nominal_hz + offset_hz;
            let q = 0.5 * hz / damping_hz;
            // Strength G / Q of the moved pole.
            let background = self.background_at(zero, n);
            let conductance = (strength - background * s) * (q / pole.q);
            *new = Pole { offset_hz, q, conductance, transient: transient - unknowns[1] * s };
            moved = moved.max((offset_hz - pole.offset_hz).abs() * q / hz).max((q / pole.q - 1.0).abs());
        }
        let c0_f = circuit.transducer(0).c0_f;
        if c0_f > 0.0 {
            // Keeps the susceptance at the first resonance for the new slope.
            let first_hz = circuit.poles.first().map_or(0.0, |pole| pole.offset_hz);
            let shift = J * (TAU * (assumed.c0_f - c0_f) * first_hz);
            (circuit.y0, circuit.c0_f) = (circuit.y0 + shift, c0_f);
        }
        let plausible =
            |pole: &Pole| pole.q > 1.0 && pole.q < 1e6 && pole.conductance.norm_sqr() > 0.0 && pole.offset_hz.is_finite();
        circuit.poles.iter().all(plausible).then_some(Solution { circuit, moved })
    }

    /// Computes the admittance without one pole, at the frequency of that pole, S.
    fn background_at(&self, hz: Phasor, which: usize) -> Phasor {
        let others = self.assumed.poles.iter().zip(pole_unknowns(&self.unknowns)).enumerate().filter(|(n, _)| *n != which);
        others.fold(self.unknowns[0], |sum, (_, (other, [g, ..]))| sum + *g * self.assumed.response(other, hz))
    }

    /// Returns the variance of the noise of the current of a line, A^2.
    pub(crate) fn variance(&self) -> f32 {
        self.triangle.variance()
    }

    /// Advances the computation of one resonance and its standard deviations. Returns `None` until
    /// it is complete.
    pub(crate) fn deviate(&mut self, found: &Circuit, which: usize) -> Option<&Transducer> {
        let Some(pole) = found.poles.get(which) else {
            self.stated = Transducer::default();
            return Some(&self.stated);
        };
        let at = CLAMPED_UNKNOWNS + POLE_UNKNOWNS * which;
        let part = self.scattered;
        self.scattered += 1;
        let of = |parts: &[(usize, Phasor)]| {
            let mut gradient = [ZERO; MAX_UNKNOWNS];
            for &(n, by) in parts {
                gradient.get_mut(n).into_iter().for_each(|place| *place = by);
            }
            self.triangle.spread(&gradient)
        };
        match part {
            0 => self.scatter.pole = of(&[(at + 2, J / pole.q)]),
            1 => {
                let background = found.y0 + found.others_admittance(which);
                let by_strength = [(at, pole.conductance.inv()), (at + 2, -background / pole.conductance)];
                self.scatter.strength = of(&by_strength);
            }
            2 => self.scatter.y0 = of(&[(0, ONE)]),
            3 => self.products = self.scatter.products(),
            4 => self.stated = found.transducer(which),
            _ => {
                let mut deviations = self.stated.deviations;
                self.products.deviate(&self.stated, part - 5, &mut deviations);
                self.stated.deviations = deviations;
            }
        }
        if part < 6 {
            return None;
        }
        self.scattered = 0;
        Some(&self.stated)
    }
}
