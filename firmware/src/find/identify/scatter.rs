//! Standard deviations of a circuit from those of the unknowns of a fit, to first order:
//! `dy = Re{g x}`.

use crate::seam::phasor::Phasor;
use crate::seam::transducer::{Deviations, Transducer};

const J: Phasor = Phasor::new(0.0, 1.0);
const ZERO: Phasor = Phasor::new(0.0, 0.0);

/// Errors of the three fitted quantities, as vectors of independent parts with variance one half
/// per axis ([`ComplexTriangle::spread`](crate::find::givens::ComplexTriangle::spread)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scatter<const N: usize> {
    /// Error of the pole `w = j / Q`, `w = f / fs - fs / f`.
    pub(crate) pole: [Phasor; N],
    /// Relative error of the strength `G / Q = 1 / (ws Lm)`.
    pub(crate) strength: [Phasor; N],
    /// Error of the clamped admittance, S.
    pub y0: [Phasor; N],
}

impl<const N: usize> Scatter<N> {
    /// Computes the sums of products from which all deviations follow.
    pub(crate) fn products(&self) -> Products {
        let product = |x: &[Phasor; N], y: &[Phasor; N]| x.iter().zip(y).map(|(x, y)| x * y.conj()).sum::<Phasor>();
        let square = |x: &[Phasor; N]| x.iter().map(|x| x.norm_sqr()).sum::<f32>();
        Products {
            squares: [square(&self.pole), square(&self.strength), square(&self.y0)],
            pole_strength: product(&self.pole, &self.strength),
            pole_y0: product(&self.pole, &self.y0),
            strength_y0: product(&self.strength, &self.y0),
        }
    }
}

/// Sums `sum x y*` over the parts, for each pair of the three quantities.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Products {
    squares: [f32; 3],
    pole_strength: Phasor,
    pole_y0: Phasor,
    strength_y0: Phasor,
}

impl Products {
    /// Writes the standard deviations of a circuit to `deviations`. The work has two parts; a block
    /// has time for one.
    pub(crate) fn deviate(&self, t: &Transducer, part: usize, deviations: &mut Deviations) {
        // Relative changes, as factors of the three quantities.
        let series = [Phasor::new(0.5, 0.0), ZERO, ZERO];
        let q = [J * t.q, ZERO, ZERO];
        let lm = [ZERO, Phasor::new(-1.0, 0.0), ZERO];
        let c0 = [ZERO, ZERO, -J / (core::f32::consts::TAU * t.series_resonance_hz * t.c0_f)];
        let sum = |parts: &[([Phasor; 3], f32)]| {
            parts.iter().fold([ZERO; 3], |[p, g, y], &([of_p, of_g, of_y], by)| [p + of_p * by, g + of_g * by, y + of_y * by])
        };
        let cm = sum(&[(lm, -1.0), (series, -2.0)]);
        let ratio = sum(&[(cm, 1.0), (c0, -1.0)]);
        let motional = t.cm_f / (t.c0_f + t.cm_f);
        if part == 0 {
            deviations.series_resonance_hz = self.deviation(series) * t.series_resonance_hz;
            deviations.parallel_resonance_hz =
                self.deviation(sum(&[(series, 1.0), (ratio, 0.5 * motional)])) * t.parallel_resonance_hz;
            deviations.q = self.deviation(q) * t.q;
            deviations.rm_ohm = self.deviation(sum(&[(lm, 1.0), (series, 1.0), (q, -1.0)])) * t.rm_ohm;
        } else {
            deviations.lm_h = self.deviation(lm) * t.lm_h;
            deviations.cm_f = self.deviation(cm) * t.cm_f;
            deviations.c0_f = self.deviation(c0) * t.c0_f;
            deviations.coupling = self.deviation(ratio) * 0.5 * (1.0 - motional) * t.coupling;
        }
    }

    /// Returns the standard deviation of a sum of the three quantities with these factors.
    fn deviation(&self, by: [Phasor; 3]) -> f32 {
        let [p, g, y] = by;
        let squares = [p, g, y].iter().zip(self.squares).map(|(by, square)| by.norm_sqr() * square).sum::<f32>();
        let crossed = |x: Phasor, y: Phasor, product: Phasor| (x * y.conj() * product).re;
        let both = crossed(p, g, self.pole_strength) + crossed(p, y, self.pole_y0) + crossed(g, y, self.strength_y0);
        let variance = 0.5 * squares + both;
        // Rounding may make the variance negative.
        if variance > 0.0 { fpu::sqrtf(variance) } else { 0.0 }
    }
}
