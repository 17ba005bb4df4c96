//! From how far the unknowns of a fit scatter to the standard deviations of a circuit: to first order, `dy = Re{g x}`.

use crate::identify::{Deviations, Transducer};
use crate::phasor::Phasor;

const J: Phasor = Phasor::new(0.0, 1.0);
const NONE: Phasor = Phasor::new(0.0, 0.0);

/// Independent parts, of variance one half each way ([`Triangle::spread`](crate::identify::triangle::Triangle::spread)), of what the circuit
/// follows from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter<const N: usize> {
    /// Of the pole `w = j / Q`, `w = f / fs - fs / f`.
    pub pole: [Phasor; N],
    /// Of the strength `G / Q = 1 / (ws Lm)`, relative.
    pub strength: [Phasor; N],
    /// Of the clamped admittance, S.
    pub y0: [Phasor; N],
}

impl<const N: usize> Scatter<N> {
    /// The deviations of a circuit.
    pub fn deviations(&self, t: &Transducer) -> Deviations {
        // Relative changes, as the factors of those three.
        let series = [Phasor::new(0.5, 0.0), NONE, NONE];
        let q = [J * t.q, NONE, NONE];
        let lm = [NONE, Phasor::new(-1.0, 0.0), NONE];
        let c0 = [NONE, NONE, -J / (core::f32::consts::TAU * t.series_resonance_hz * t.c0_f)];
        let sum =
            |parts: &[([Phasor; 3], f32)]| parts.iter().fold([NONE; 3], |sum, (of, by)| [0, 1, 2].map(|n| sum[n] + of[n] * *by));
        let cm = sum(&[(lm, -1.0), (series, -2.0)]);
        let ratio = sum(&[(cm, 1.0), (c0, -1.0)]);
        let part = t.cm_f / (t.c0_f + t.cm_f);
        Deviations {
            series_resonance_hz: self.of(series) * t.series_resonance_hz,
            parallel_resonance_hz: self.of(sum(&[(series, 1.0), (ratio, 0.5 * part)])) * t.parallel_resonance_hz,
            q: self.of(q) * t.q,
            rm_ohm: self.of(sum(&[(lm, 1.0), (series, 1.0), (q, -1.0)])) * t.rm_ohm,
            lm_h: self.of(lm) * t.lm_h,
            cm_f: self.of(cm) * t.cm_f,
            c0_f: self.of(c0) * t.c0_f,
            coupling: self.of(ratio) * 0.5 * (1.0 - part) * t.coupling,
        }
    }

    fn of(&self, by: [Phasor; 3]) -> f32 {
        let parts = self.pole.iter().zip(&self.strength).zip(&self.y0);
        libm::sqrtf(0.5 * parts.map(|((p, g), y)| (p * by[0] + g * by[1] + y * by[2]).norm_sqr()).sum::<f32>())
    }
}
