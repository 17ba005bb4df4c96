//! What moves the elements of a stack by itself: temperature and amplitude.
//!
//! `fs = fs0 + a T + d |Im|^2`, `C0 = C00 (1 + c T)`: `T` is the rise over ambient, `|Im|` the amplitude of the motional current. The
//! motional inductance and the quality factor stay, so that `Cm = 1 / (omega_s^2 Lm)`. To first order in the shift this is the
//! cubic spring of Duffing (1918): `d` in Hz/A^2 is three eighths of the cubic over the linear stiffness, times `fs`, times the square of the
//! displacement of one ampere. Piezoceramics soften: `d < 0`.
//!
//! The amplitude is that of the block's beginning, at any frequency; within a block it moves by the block's part of the ring-up time. A sum
//! beyond [`FARTHEST`] of the resonance is held there: the laws are first terms of series.

use crate::circuit::Circuit;

/// Farthest that temperature and amplitude together move the resonance, relative to where it is without them.
pub const FARTHEST: f64 = 0.2;

/// How temperature and amplitude move the elements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shift {
    /// Series resonance by temperature, Hz/K.
    temperature_hz_per_k: f64,
    /// Clamped capacitance by temperature, relative, 1/K.
    temperature_c0_per_k: f64,
    /// Series resonance by the square of the motional current's amplitude, Hz/A^2.
    duffing_hz_per_a2: f64,
}

impl Shift {
    /// What a scene says; none if nothing moves.
    pub fn of(bvd: &scene::Bvd) -> Option<Self> {
        let shift = Shift {
            temperature_hz_per_k: bvd.temperature_hz_per_k,
            temperature_c0_per_k: bvd.temperature_c0_per_k,
            duffing_hz_per_a2: bvd.duffing_hz_per_a2,
        };
        (shift != Shift::default()).then_some(shift)
    }

    /// The circuit at a temperature over ambient, K, and an amplitude of the motional current, A.
    pub fn apply(&self, rest: &Circuit, temperature_k: f64, amplitude_a: f64) -> Circuit {
        let hz = rest.series_resonance_hz();
        let by = self.temperature_hz_per_k * temperature_k + self.duffing_hz_per_a2 * amplitude_a * amplitude_a;
        let c0_f = rest.c0_f * (1.0 + (self.temperature_c0_per_k * temperature_k).clamp(-0.9, 9.0));
        Circuit { c0_f, ..rest.with_series_resonance(hz + by.clamp(-FARTHEST * hz, FARTHEST * hz)) }
    }
}
