//! Resonances from the spectrum of a record in which nothing has to be settled.
//!
//! Voltage and current of a Butterworth-Van Dyke circuit of several branches obey, at each line `f` of a [spectrum](crate::scan::spectrum),
//!
//! ```text
//! I = Y0 V + T0 + sum (G V + T) phi(f),    phi(f) = 1 / (1 + j Q (f / fs - fs / f))
//! ```
//!
//! The `T` are what rings at the beginning and at the end of the record: for a rational system they are of this form exactly, whatever was
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

use heapless::Vec;

use crate::demod::Sensed;
use crate::identify::scatter::{Products, Scatter};
use crate::identify::triangle::Triangle;
use crate::identify::{Deviations, MOST_MODES, Transducer};
use crate::motional::Motional;
use crate::phasor::{Phasor, direction, magnitude};

const TAU: f32 = core::f32::consts::TAU;
const J: Phasor = Phasor::new(0.0, 1.0);
const ONE: Phasor = Phasor::new(1.0, 0.0);
const NONE: Phasor = Phasor::new(0.0, 0.0);

/// Unknowns of the clamped branch, and of each resonance: `G`, `T` and `s`.
const CLAMPED: usize = 2;
const EACH: usize = 3;
/// The most unknowns.
const MOST: usize = CLAMPED + EACH * MOST_MODES;
/// Rotations of a row that a block has time for: those of a row of one resonance.
const ROTATIONS: usize = 20;
/// Steps towards the zeros of `1 + sum s phi`; the next iteration goes on where these end.
const STEPS: usize = 4;

/// One resonance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pole {
    /// Series resonance, as an offset from the nominal frequency, Hz.
    pub offset_hz: f32,
    /// Quality factor.
    pub q: f32,
    /// Admittance at the series resonance, S.
    pub conductance: Phasor,
    /// What rings by itself, at the same place, A.
    pub transient: Phasor,
}

/// All resonances, and what is left without them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Circuit {
    /// Middle of the window, Hz.
    pub nominal_hz: f32,
    /// The resonances.
    pub poles: Vec<Pole, MOST_MODES>,
    /// Resonances that are known from elsewhere: none of these is fitted, nor do they ring by themselves.
    pub known: Vec<Pole, MOST_MODES>,
    /// Admittance of the clamped branch at the nominal frequency, S; its susceptance rises with frequency.
    pub y0: Phasor,
    /// Clamped capacitance by which it rises, F.
    pub c0_f: f32,
    /// What of the current is nobody's, A.
    pub rest: Phasor,
}

impl Circuit {
    /// A bare capacitance.
    pub fn bare(nominal_hz: f32, c0_f: f32) -> Self {
        Circuit { nominal_hz, c0_f, y0: J * (TAU * nominal_hz * c0_f), ..Circuit::default() }
    }

    /// The current in a line of the record that this was found in.
    pub fn current(&self, offset_hz: f32, v: Phasor) -> Phasor {
        let poles: Phasor =
            self.poles.iter().map(|pole| (pole.conductance * v + pole.transient) * self.phi(pole, offset_hz)).sum();
        (self.y0 + self.fixed(offset_hz)) * v + self.rest + poles
    }

    /// What the other resonances that were fitted add to the admittance at the place of one, S.
    fn beside(&self, which: usize) -> Phasor {
        let Some(at) = self.poles.get(which) else { return NONE };
        let others = self.poles.iter().enumerate().filter(|(n, _)| *n != which);
        others.map(|(_, pole)| pole.conductance * self.phi(pole, at.offset_hz)).sum()
    }

    /// The circuit of one resonance, without its deviations.
    pub fn transducer(&self, which: usize) -> Transducer {
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
    pub fn motional(&self, which: usize) -> Motional {
        let Some(pole) = self.poles.get(which) else { return Motional { y0: self.y0, axis: ONE } };
        let there = self.y0 + self.fixed(pole.offset_hz) + self.beside(which);
        let relative = (self.nominal_hz + pole.offset_hz) / self.nominal_hz;
        Motional { y0: Phasor::new(there.re, there.im / relative), axis: direction(pole.conductance) }
    }

    /// What the clamped capacitance takes more at this offset than at the nominal frequency, S.
    fn slope(&self, offset_hz: f32) -> Phasor {
        J * (TAU * self.c0_f * offset_hz)
    }

    /// What is not fitted at this offset, S.
    fn fixed(&self, offset_hz: f32) -> Phasor {
        let known: Phasor = self.known.iter().map(|pole| pole.conductance * self.phi(pole, offset_hz)).sum();
        self.slope(offset_hz) + known
    }

    /// How much a pole answers at an offset.
    fn phi(&self, pole: &Pole, offset_hz: f32) -> Phasor {
        self.answer(pole, Phasor::new(offset_hz, 0.0))
    }

    /// The same at a complex frequency.
    fn answer(&self, pole: &Pole, offset_hz: Phasor) -> Phasor {
        let ratio = (offset_hz - pole.offset_hz) / (self.nominal_hz + pole.offset_hz);
        let detuning = if ratio.im == 0.0 {
            Phasor::new(ratio.re * (2.0 + ratio.re) / (1.0 + ratio.re), 0.0)
        } else {
            ratio * (ratio + 2.0) / (ratio + 1.0)
        };
        (ONE + J * detuning * pole.q).inv()
    }
}

/// The fit, gathering rows.
#[derive(Clone, Debug)]
pub struct PoleFit {
    assumed: Circuit,
    /// Noise of the voltage over that of the current, ohm.
    noise_ohm: f32,
    triangle: Triangle<MOST>,
    /// What has been solved so far, and how many parts of the solution are done.
    unknowns: [Phasor; MOST],
    zeros: [Phasor; MOST_MODES],
    solved: usize,
    /// The same of the deviations of a resonance.
    scatter: Scatter<MOST>,
    products: Products,
    scattered: usize,
}

/// What a block's worth of solving has come to.
#[derive(Clone, Debug, PartialEq)]
pub enum Solving {
    /// It takes more blocks.
    More,
    /// The lines do not determine the circuit, or it is no resonance.
    Nothing,
    /// The circuit.
    Found(Solution),
}

/// What a fit has found.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// The circuit.
    pub circuit: Circuit,
    /// How far the poles have moved, in parts of their width.
    pub moved: f32,
}

impl PoleFit {
    /// An empty fit about what is assumed. `noise_ohm` is the noise of the voltage over that of the current: as their steps, where both
    /// converters are alike.
    pub fn new(assumed: Circuit, noise_ohm: f32) -> Self {
        let unknowns = CLAMPED + EACH * assumed.poles.len();
        PoleFit {
            assumed,
            noise_ohm,
            triangle: Triangle::new(unknowns),
            unknowns: [NONE; MOST],
            zeros: [NONE; MOST_MODES],
            solved: 0,
            scatter: Scatter { pole: [NONE; MOST], strength: [NONE; MOST], y0: [NONE; MOST] },
            products: Products::default(),
            scattered: 0,
        }
    }

    /// Begins again about what is assumed now.
    pub fn restart(&mut self, assumed: &Circuit) {
        self.assumed.clone_from(assumed);
        self.triangle.restart(CLAMPED + EACH * assumed.poles.len());
        (self.solved, self.scattered) = (0, 0);
    }

    /// Adds a line, as far as a block has time for. Returns whether it is done with it.
    pub fn add(&mut self, offset_hz: f32, line: &Sensed) -> bool {
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

    /// What the lines say, as far as a block has time for.
    pub fn solve(&mut self) -> Solving {
        loop {
            let part = self.solved;
            self.solved += 1;
            match part {
                0 => match self.triangle.solve() {
                    Some(unknowns) => self.begin_zeros(unknowns),
                    None => return Solving::Nothing,
                },
                1..=STEPS => self.move_zeros(),
                _ => return self.finish().map_or(Solving::Nothing, Solving::Found),
            }
            // A block has time for all that follows only where there is no more than one resonance.
            if part == 0 || self.assumed.poles.len() > 1 {
                return Solving::More;
            }
        }
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
        let s = |n: usize| unknowns[CLAMPED + EACH * n + 2];
        for (n, (zero, pole)) in self.zeros.iter_mut().zip(&assumed.poles).enumerate() {
            let others = assumed.poles.iter().enumerate().filter(|(k, _)| *k != n);
            let rest: Phasor = others.map(|(k, other)| s(k) * assumed.answer(other, *zero)).sum();
            // 1 + j Q w = -s / (1 + others), hence w.
            let w = J * (ONE + s(n) / (ONE + rest)) / pole.q;
            *zero = assumed.complex_hz(pole, w);
        }
    }

    fn finish(&self) -> Option<Solution> {
        let of = |n: usize| CLAMPED + EACH * n;
        let (assumed, unknowns, zeros) = (&self.assumed, &self.unknowns, &self.zeros);
        let mut circuit = assumed.clone();
        (circuit.y0, circuit.rest) = (unknowns[0], unknowns[1]);
        let s = |n: usize| unknowns[of(n) + 2];
        let mut moved: f32 = 0.0;
        for (n, pole) in assumed.poles.iter().enumerate() {
            // The resonance is as far from zero as the pole. What would grow is taken for what decays as fast.
            let damping_hz = zeros[n].im.abs();
            let offset_hz = zeros[n].re + 0.5 * damping_hz * damping_hz / (assumed.nominal_hz + zeros[n].re);
            let hz = assumed.nominal_hz + offset_hz;
            let q = 0.5 * hz / damping_hz;
            // The strength G / Q of a pole that has moved.
            let background = assumed.background_at(zeros[n], n, unknowns);
            let conductance = (unknowns[of(n)] - background * s(n)) * (q / pole.q);
            let new = Pole { offset_hz, q, conductance, transient: unknowns[of(n) + 1] - unknowns[1] * s(n) };
            moved = moved.max((new.offset_hz - pole.offset_hz).abs() * q / hz).max((q / pole.q - 1.0).abs());
            circuit.poles[n] = new;
        }
        let c0_f = circuit.transducer(0).c0_f;
        if c0_f > 0.0 {
            // By the same slope at the place of the first resonance.
            let shift = J * (TAU * (assumed.c0_f - c0_f) * circuit.poles[0].offset_hz);
            (circuit.y0, circuit.c0_f) = (circuit.y0 + shift, c0_f);
        }
        let plausible =
            |pole: &Pole| pole.q > 1.0 && pole.q < 1e6 && pole.conductance.norm_sqr() > 0.0 && pole.offset_hz.is_finite();
        circuit.poles.iter().all(plausible).then_some(Solution { circuit, moved })
    }

    /// Variance of the noise of a line's current, A^2.
    pub fn variance(&self) -> f32 {
        self.triangle.variance()
    }

    /// By how much the numbers of one resonance of what was found scatter; `None` while that takes more blocks.
    pub fn deviations(&mut self, found: &Circuit, which: usize) -> Option<Deviations> {
        let Some(pole) = found.poles.get(which) else { return Some(Deviations::default()) };
        let at = CLAMPED + EACH * which;
        let part = self.scattered;
        self.scattered += 1;
        let of = |parts: &[(usize, Phasor)]| {
            let mut gradient = [NONE; MOST];
            parts.iter().for_each(|&(n, by)| gradient[n] = by);
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
            _ => {
                self.scattered = 0;
                return Some(self.products.deviations(&found.transducer(which)));
            }
        }
        None
    }
}

impl Circuit {
    /// The complex frequency at which the detuning of a pole is `w`, as an offset from the nominal one, Hz.
    fn complex_hz(&self, pole: &Pole, w: Phasor) -> Phasor {
        let half = w * 0.5;
        (half + half * half * 0.5) * (self.nominal_hz + pole.offset_hz) + pole.offset_hz
    }

    /// The admittance beside a pole, where that pole is, by the unknowns.
    fn background_at(&self, hz: Phasor, which: usize, unknowns: &[Phasor; MOST]) -> Phasor {
        let others = self.poles.iter().enumerate().filter(|(n, _)| *n != which);
        others.fold(unknowns[0], |sum, (n, other)| sum + unknowns[CLAMPED + EACH * n] * self.answer(other, hz))
    }
}
