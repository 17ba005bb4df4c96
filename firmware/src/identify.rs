//! The transducer from its admittance circle.
//!
//! With `w = f / fc - fc / f` about any centre `fc` inside the resonance, the Butterworth-Van Dyke admittance is
//!
//! ```text
//! Y = Y0 + G / (1 + j Q (w - ws))        <=>        Y = A + B (w Y) + D w,
//! 1 / B = ws + j / Q,    Y0 = -D / B,    G = (A - Y0) (1 - j Q ws),
//! ```
//!
//! linear in the three complex unknowns A, B, D (Levy 1959). Each row is divided by `|1 + j Q (w - ws)|` of the estimate
//! so far (Sanathanan and Koerner 1963), which restores uniform noise. Rows are folded into a triangular factor by Givens
//! rotations as they arrive: no storage, a few hundred operations a point, and the condition number is not squared, which
//! is what makes f32 enough.
//!
//! `G` comes out complex: its argument is what the sensing chain adds, and becomes the axis of the motional phase, so that
//! skew between the converters does not move the lock point.

use serde::{Deserialize, Serialize};

use crate::motional::Motional;
use crate::phasor::{Phasor, direction, magnitude};

const TAU: f32 = core::f32::consts::TAU;
const J: Phasor = Phasor::new(0.0, 1.0);

/// A transducer's equivalent circuit, as identified.
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
    /// Clamped capacitance, F; includes what DAC images make it look like.
    pub c0_f: f32,
}

impl Transducer {
    /// Ring-up time constant `Q / (pi fs)`, s.
    pub fn time_constant_s(&self) -> f32 {
        2.0 * self.q / (TAU * self.series_resonance_hz)
    }
}

/// What is assumed about the resonance while points are gathered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guess {
    /// Series resonance, Hz.
    pub hz: f32,
    /// Quality factor.
    pub q: f32,
    /// Clamped capacitance, F. Only its slope over the span is taken from here.
    pub c0_f: f32,
}

/// The fit, gathering points.
#[derive(Clone, Debug)]
pub struct CircleFit {
    guess: Guess,
    /// Scale of `w`: half the span.
    half_width: f32,
    /// Upper triangle and right-hand side.
    rows: [[Phasor; 4]; 3],
}

impl CircleFit {
    /// An empty fit about `guess`, for points up to `half_span_hz` on each side.
    pub fn new(guess: Guess, half_span_hz: f32) -> Self {
        CircleFit { guess, half_width: 2.0 * half_span_hz / guess.hz, rows: Default::default() }
    }

    /// Adds the admittance `y`, S, at `hz`.
    pub fn add(&mut self, hz: f32, y: Phasor) {
        let w = self.detuning(hz);
        let b0 = self.clamped_susceptance();
        let scaled = (y - J * (b0 * 0.5 * w)) / b0;
        let weight = 1.0 / libm::sqrtf(1.0 + (self.guess.q * w) * (self.guess.q * w));
        let x = w / self.half_width;
        let one = Phasor::new(weight, 0.0);
        self.fold([one, scaled * (x * weight), one * x, scaled * weight]);
    }

    /// The transducer, and the motional branch for tracking; `None` if the points show no resonance.
    ///
    /// `nominal_hz` is the frequency at which [`Motional::y0`] is stated.
    pub fn solve(&self, nominal_hz: f32) -> Option<(Transducer, Motional)> {
        let [a, b, d] = self.back_substitute()?;
        let inverse = b.inv();
        let (ws, q) = (inverse.re * self.half_width, 1.0 / (inverse.im * self.half_width));
        let y0 = -d * inverse;
        let b0 = self.clamped_susceptance();
        let g = (a - y0) * Phasor::new(1.0, -q * ws) * b0;
        // f / fc - fc / f = ws
        let hz = self.guess.hz * (0.5 * ws + libm::sqrtf(1.0 + 0.25 * ws * ws));
        // The fit saw y0 at its own centre, less the slope; state it at the resonance, then per unit of frequency.
        let c0_f = (y0.im * b0 + b0 * 0.5 * ws) / (TAU * hz);
        let rm_ohm = 1.0 / magnitude(g);
        let lm_h = q * rm_ohm / (TAU * hz);
        let cm_f = 1.0 / (TAU * hz * q * rm_ohm);
        let plausible = q > 1.0 && q < 1e6 && ws.abs() <= 2.0 * self.half_width && c0_f > 0.0 && rm_ohm.is_finite();
        plausible.then(|| {
            let parallel = hz * libm::sqrtf(1.0 + cm_f / c0_f);
            let transducer = Transducer { series_resonance_hz: hz, parallel_resonance_hz: parallel, q, rm_ohm, lm_h, cm_f, c0_f };
            let y0 = Phasor::new(y0.re * b0, TAU * nominal_hz * c0_f);
            (transducer, Motional { y0, axis: direction(g) })
        })
    }

    fn detuning(&self, hz: f32) -> f32 {
        let ratio = (hz - self.guess.hz) / self.guess.hz;
        ratio * (2.0 + ratio) / (1.0 + ratio)
    }

    fn clamped_susceptance(&self) -> f32 {
        TAU * self.guess.hz * self.guess.c0_f
    }

    fn fold(&mut self, mut row: [Phasor; 4]) {
        for (pivot, kept) in self.rows.iter_mut().enumerate() {
            let (a, b) = (kept[pivot], row[pivot]);
            let size = libm::sqrtf(a.norm_sqr() + b.norm_sqr());
            if size == 0.0 {
                continue;
            }
            for column in pivot..4 {
                let (x, y) = (kept[column], row[column]);
                kept[column] = (a.conj() * x + b.conj() * y) / size;
                row[column] = (a * y - b * x) / size;
            }
        }
    }

    fn back_substitute(&self) -> Option<[Phasor; 3]> {
        let mut unknowns = [Phasor::default(); 3];
        for n in (0..3).rev() {
            let row = &self.rows[n];
            let known = (n + 1..3).fold(row[3], |rest, k| rest - row[k] * unknowns[k]);
            if row[n].norm_sqr() == 0.0 {
                return None;
            }
            unknowns[n] = known / row[n];
        }
        Some(unknowns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Set A3 of the flagship stack, seen through a current channel that turns by `skew` and a leak of 1 mS.
    fn admittance(hz: f32, skew: f32) -> Phasor {
        let w = TAU * hz;
        let (rm, lm, cm, c0) = (3.08, 791.6e-6, 19.999e-9, 300e-9);
        let branch = Phasor::new(rm, w * lm - 1.0 / (w * cm)).inv();
        (branch + Phasor::new(1e-3, w * c0)) * Phasor::new(libm::cosf(skew), libm::sinf(skew))
    }

    fn identify(guess_hz: f32, skew: f32) -> (Transducer, Motional) {
        let mut fit = CircleFit::new(Guess { hz: guess_hz, q: 60.0, c0_f: 290e-9 }, 1000.0);
        for n in 0..15 {
            let hz = guess_hz - 1000.0 + 2000.0 * n as f32 / 14.0;
            fit.add(hz, admittance(hz, skew));
        }
        fit.solve(40e3).unwrap()
    }

    #[test]
    fn finds_every_element_of_a_known_circuit() {
        let exact_hz = 1.0 / (TAU * libm::sqrtf(791.6e-6 * 19.999e-9));
        for guess in [39_600.0, 40_000.0, 40_350.0] {
            let (found, motional) = identify(guess, 0.0);
            assert!((found.series_resonance_hz - exact_hz).abs() < 0.5, "{found:?}");
            assert!((found.q / (TAU * exact_hz * 791.6e-6 / 3.08) - 1.0).abs() < 2e-3, "{found:?}");
            assert!((found.rm_ohm / 3.08 - 1.0).abs() < 2e-3, "{found:?}");
            assert!((found.c0_f / 300e-9 - 1.0).abs() < 3e-3, "{found:?}");
            assert!((motional.y0.re - 1e-3).abs() < 3e-4, "{motional:?}");
        }
    }

    #[test]
    fn skew_turns_the_axis_and_leaves_the_resonance() {
        let (plain, _) = identify(40_000.0, 0.0);
        let (skewed, motional) = identify(40_000.0, 0.02);
        assert!((plain.series_resonance_hz - skewed.series_resonance_hz).abs() < 0.2, "{plain:?} {skewed:?}");
        assert!((motional.axis.im - 0.02).abs() < 1e-3, "{motional:?}");
    }

    #[test]
    fn a_bare_capacitor_is_no_resonance() {
        let mut fit = CircleFit::new(Guess { hz: 40e3, q: 60.0, c0_f: 300e-9 }, 1000.0);
        for n in 0..15 {
            let hz = 39_000.0 + 2000.0 * n as f32 / 14.0;
            fit.add(hz, Phasor::new(0.0, TAU * hz * 300e-9));
        }
        assert!(fit.solve(40e3).is_none_or(|(found, _)| found.rm_ohm > 1e3));
    }
}
