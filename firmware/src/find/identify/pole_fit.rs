//! Resonances from the spectrum of a record in which nothing has to be settled.
//!
//! Voltage and current of a Butterworth-Van Dyke circuit of several branches obey, at each line `f` of a [spectrum](crate::find::scan::spectrum),
//!
//! ```text
//! I = Y0 V + T0 + sum (G V + T) phi(f),    phi(f) = 1 / (1 + j Q (f / fs - fs / f))
//! ```
//!
//! The `T` are the free vibration at the beginning and at the end of the record: for a rational system they are of this form exactly, whatever was
//! before and whatever was cut off (R. Pintelon, J. Schoukens and G. Vandersteen 1997), so that nothing has to settle. With poles that are
//! assumed, and the unknown `s` for how wrong they are,
//!
//! ```text
//! I = Y0 V + T0 + sum (G V + T - s I) phi(f)
//! ```
//!
//! is linear, and the poles are moved to the zeros of `1 + sum s phi` until they stand still (B. Gustavsen and A. Semlyen 1999; of one pole
//! it is C. K. Sanathanan and J. Koerner 1963). Each row is divided by the noise of `I - Y V`.
//!
//! `G` comes out complex: its argument is what the sensing chain adds, and becomes the axis of the motional phase. `Y0` comes out as the
//! converters see it. Valid for resonances inside the spectrum, with Q above about five.

use crate::find::givens::ComplexTriangle;
pub(crate) use crate::find::identify::circuit::{Circuit, Pole};
use crate::find::identify::scatter::{Products, Scatter};
use crate::seam::phasor::Phasor;
use crate::seam::transducer::{MOST_MODES, Transducer};
use crate::sense::demod::Sensed;

const TAU: f32 = core::f32::consts::TAU;
const J: Phasor = Phasor::new(0.0, 1.0);
const ONE: Phasor = Phasor::new(1.0, 0.0);
const NONE: Phasor = Phasor::new(0.0, 0.0);

/// Unknowns of the clamped branch, and of each resonance.
const CLAMPED: usize = 2;
const EACH: usize = 3;
/// The most unknowns.
const MOST: usize = CLAMPED + EACH * MOST_MODES;
/// Rotations of a row that a block has time for: those of a row of one resonance.
const ROTATIONS: usize = 20;
/// Steps towards the zeros of `1 + sum s phi`; the next iteration goes on where these end.
const STEPS: usize = 4;

/// The fit, gathering rows.
#[derive(Clone, Debug)]
pub(crate) struct PoleFit {
    assumed: Circuit,
    /// Noise of the voltage over that of the current, ohm.
    noise_ohm: f32,
    triangle: ComplexTriangle<MOST>,
    /// What has been solved so far, and how many parts of the solution are done.
    unknowns: [Phasor; MOST],
    zeros: [Phasor; MOST_MODES],
    determined: bool,
    solved: usize,
    /// The same of the deviations of a resonance.
    scatter: Scatter<MOST>,
    products: Products,
    scattered: usize,
    /// The resonance that is being stated, with its deviations.
    stated: Transducer,
}

/// What a fit has found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Solution {
    /// The circuit.
    pub(crate) circuit: Circuit,
    /// How far the poles have moved, in parts of their width.
    pub(crate) moved: f32,
}

/// The unknowns of each resonance: `G`, `T` and `s`.
fn of_each(unknowns: &[Phasor; MOST]) -> &[[Phasor; EACH]] {
    unknowns[CLAMPED..].as_chunks().0
}

impl PoleFit {
    /// An empty fit about what is assumed. `noise_ohm` is the noise of the voltage over that of the current: as their steps, where both
    /// converters are alike.
    pub(crate) fn new(assumed: Circuit, noise_ohm: f32) -> Self {
        let unknowns = CLAMPED + EACH * assumed.poles.len();
        PoleFit {
            assumed,
            noise_ohm,
            triangle: ComplexTriangle::new(unknowns),
            unknowns: [NONE; MOST],
            zeros: [NONE; MOST_MODES],
            determined: false,
            solved: 0,
            scatter: Scatter { pole: [NONE; MOST], strength: [NONE; MOST], y0: [NONE; MOST] },
            products: Products::default(),
            scattered: 0,
            stated: Transducer::default(),
        }
    }

    /// Begins again about what is assumed now.
    pub(crate) fn restart(&mut self, assumed: &Circuit) {
        self.assumed.clone_from(assumed);
        self.triangle.restart(CLAMPED + EACH * assumed.poles.len());
        (self.solved, self.scattered) = (0, 0);
    }

    /// Adds a line, as far as a block has time for. Returns whether it is done with it.
    pub(crate) fn add(&mut self, offset_hz: f32, line: &Sensed) -> bool {
        if self.triangle.is_idle() {
            self.begin(offset_hz, line);
        }
        self.triangle.fold(ROTATIONS)
    }

    fn begin(&mut self, offset_hz: f32, line: &Sensed) {
        let circuit = &self.assumed;
        let fixed = circuit.fixed(offset_hz);
        let mut y = circuit.y0 + fixed;
        let mut phis = [NONE; MOST_MODES];
        for (phi, pole) in phis.iter_mut().zip(&circuit.poles) {
            *phi = circuit.phi(pole, offset_hz);
            y += pole.conductance * *phi;
        }
        let weight = 1.0 / libm::sqrtf(1.0 + self.noise_ohm * self.noise_ohm * y.norm_sqr());
        let (v, i) = (line.v * weight, (line.i - line.v * fixed) * weight);
        let mut row = [NONE; MOST];
        (row[0], row[1]) = (v, ONE * weight);
        for (columns, phi) in row[CLAMPED..].chunks_exact_mut(EACH).zip(&phis).take(circuit.poles.len()) {
            columns.copy_from_slice(&[v * phi, phi * weight, -i * phi]);
        }
        self.triangle.add(row, i);
    }

    /// Solves for what the lines say, as far as a block has time for. Returns whether there is a [solution](Self::solution) now, if any.
    pub(crate) fn solve(&mut self) -> bool {
        if self.solved == 0 {
            self.solved = 1;
            let unknowns = self.triangle.solve();
            self.determined = unknowns.is_some();
            self.begin_zeros(unknowns.unwrap_or_default());
            return !self.determined;
        }
        // A block has time for all steps only where there is no more than one resonance.
        let steps = if self.assumed.poles.len() > 1 { 1 } else { STEPS };
        if self.solved <= STEPS {
            (0..steps).for_each(|_| self.move_zeros());
            self.solved += steps;
        }
        self.solved > STEPS
    }

    fn begin_zeros(&mut self, unknowns: [Phasor; MOST]) {
        self.unknowns = unknowns;
        for (zero, pole) in self.zeros.iter_mut().zip(&self.assumed.poles) {
            *zero = self.assumed.complex_hz(pole, J / pole.q);
        }
    }

    /// One step towards the zeros.
    fn move_zeros(&mut self) {
        let (assumed, unknowns) = (&self.assumed, &self.unknowns);
        let solved = of_each(unknowns);
        for (n, ((zero, pole), [_, _, s])) in self.zeros.iter_mut().zip(&assumed.poles).zip(solved).enumerate() {
            let others = assumed.poles.iter().zip(solved).enumerate().filter(|(k, _)| *k != n);
            let rest: Phasor = others.map(|(_, (other, [_, _, s]))| *s * assumed.answer(other, *zero)).sum();
            // 1 + j Q w = -s / (1 + others), hence w.
            let w = J * (ONE + *s / (ONE + rest)) / pole.q;
            *zero = assumed.complex_hz(pole, w);
        }
    }

    /// What the lines say; `None` if they do not determine it, or if it is no resonance.
    pub(crate) fn solution(&self) -> Option<Solution> {
        if !self.determined {
            return None;
        }
        let (assumed, unknowns) = (&self.assumed, &self.unknowns);
        let mut circuit = assumed.clone();
        (circuit.y0, circuit.rest) = (unknowns[0], unknowns[1]);
        let solved = of_each(unknowns).iter().zip(&self.zeros);
        let mut moved: f32 = 0.0;
        for (((n, pole), new), (&[strength, transient, s], &zero)) in
            assumed.poles.iter().enumerate().zip(&mut circuit.poles).zip(solved)
        {
            // The resonance is as far from zero as the pole. What would grow is taken for what decays as fast.
            let damping_hz = zero.im.abs();
            let offset_hz = zero.re + 0.5 * damping_hz * damping_hz / (assumed.nominal_hz + zero.re);
            let hz = assumed.nominal_hz + offset_hz;
            let q = 0.5 * hz / damping_hz;
            // The strength G / Q of a pole that has moved.
            let background = self.background_at(zero, n);
            let conductance = (strength - background * s) * (q / pole.q);
            *new = Pole { offset_hz, q, conductance, transient: transient - unknowns[1] * s };
            moved = moved.max((offset_hz - pole.offset_hz).abs() * q / hz).max((q / pole.q - 1.0).abs());
        }
        let c0_f = circuit.transducer(0).c0_f;
        if c0_f > 0.0 {
            // By the same slope at the place of the first resonance.
            let first_hz = circuit.poles.first().map_or(0.0, |pole| pole.offset_hz);
            let shift = J * (TAU * (assumed.c0_f - c0_f) * first_hz);
            (circuit.y0, circuit.c0_f) = (circuit.y0 + shift, c0_f);
        }
        let plausible =
            |pole: &Pole| pole.q > 1.0 && pole.q < 1e6 && pole.conductance.norm_sqr() > 0.0 && pole.offset_hz.is_finite();
        circuit.poles.iter().all(plausible).then_some(Solution { circuit, moved })
    }

    /// The admittance beside a pole, where that pole is, by the unknowns.
    fn background_at(&self, hz: Phasor, which: usize) -> Phasor {
        let others = self.assumed.poles.iter().zip(of_each(&self.unknowns)).enumerate().filter(|(n, _)| *n != which);
        others.fold(self.unknowns[0], |sum, (_, (other, [g, ..]))| sum + *g * self.assumed.answer(other, hz))
    }

    /// Variance of the noise of a line's current, A^2.
    pub(crate) fn variance(&self) -> f32 {
        self.triangle.variance()
    }

    /// Goes on with one resonance of what was found, and by how much its numbers scatter; `None` while that takes more blocks.
    pub(crate) fn state(&mut self, found: &Circuit, which: usize) -> Option<&Transducer> {
        let Some(pole) = found.poles.get(which) else {
            self.stated = Transducer::default();
            return Some(&self.stated);
        };
        let at = CLAMPED + EACH * which;
        let part = self.scattered;
        self.scattered += 1;
        let of = |parts: &[(usize, Phasor)]| {
            let mut gradient = [NONE; MOST];
            for &(n, by) in parts {
                gradient.get_mut(n).into_iter().for_each(|place| *place = by);
            }
            self.triangle.spread(&gradient)
        };
        match part {
            0 => self.scatter.pole = of(&[(at + 2, J / pole.q)]),
            1 => {
                let background = found.y0 + found.beside(which);
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
