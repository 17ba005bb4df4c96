//! The forcing within a smooth piece: a cosine whose frequency changes linearly, or a straight
//! line.

use std::f64::consts::TAU;

use super::turn::sine_cosine;

/// Forcing within a piece, as a function of the time s since the beginning of the piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Forcing {
    /// `size cos(2 pi (turns + hz s + hz_per_s s^2 / 2))`.
    Cosine {
        /// Peak value.
        size: f64,
        /// Phase at the beginning, turns.
        turns: f64,
        /// Frequency at the beginning, Hz.
        hz: f64,
        /// Rate of change of the frequency, Hz/s.
        hz_per_s: f64,
    },
    /// `value + slope s`.
    Line {
        /// Value at the beginning.
        value: f64,
        /// Change per second.
        slope: f64,
    },
}

impl Forcing {
    /// Returns the forcing `s` seconds after the beginning.
    pub fn value(&self, s: f64) -> f64 {
        match *self {
            Forcing::Cosine { size, turns, hz, hz_per_s } => size * (TAU * (turns + s * (hz + 0.5 * hz_per_s * s))).cos(),
            Forcing::Line { value, slope } => value + slope * s,
        }
    }

    /// Returns the same forcing with its time counted from `s` seconds after the beginning.
    pub fn later(&self, s: f64) -> Forcing {
        match *self {
            Forcing::Cosine { size, turns, hz, hz_per_s } => {
                let turns = turns + s * (hz + 0.5 * hz_per_s * s);
                Forcing::Cosine { size, turns, hz: hz + hz_per_s * s, hz_per_s }
            }
            Forcing::Line { value, slope } => Forcing::Line { value: value + slope * s, slope },
        }
    }

    /// Returns the largest frequency within `length_s` seconds from the beginning, Hz; `None` for a
    /// line.
    pub fn fastest_hz(&self, length_s: f64) -> Option<f64> {
        match *self {
            Forcing::Cosine { hz, hz_per_s, .. } => Some(hz.max(hz + hz_per_s * length_s)),
            Forcing::Line { .. } => None,
        }
    }

    /// Returns the Taylor coefficients about `s`: the forcing at `s + d` is the sum of
    /// `out[k] d^k`.
    pub fn taylor<const N: usize>(&self, s: f64) -> [f64; N] {
        self.taylor_in(s, 1.0)
    }

    /// Returns the Taylor coefficients about `s` in units of `unit` seconds: the forcing at
    /// `s + d unit` is the sum of `out[k] d^k`.
    ///
    /// For a cosine with phase p and p' = w + r d: y = cos p, z = sin p, (k+1) y_{k+1} = -(w z_k +
    /// r z_{k-1}), (k+1) z_{k+1} = w y_k + r y_{k-1}.
    pub fn taylor_in<const N: usize>(&self, s: f64, unit: f64) -> [f64; N] {
        let mut out = [0.0; N];
        match *self {
            Forcing::Cosine { size, turns, hz, hz_per_s } => {
                let (omega, rate) = (TAU * (hz + hz_per_s * s) * unit, TAU * hz_per_s * unit * unit);
                let (sine, cosine) = sine_cosine(turns + s * (hz + 0.5 * hz_per_s * s));
                let (mut y, mut z) = (size * cosine, size * sine);
                if rate == 0.0 {
                    // At constant frequency, each pair of coefficients is the previous one turned
                    // by 90 degrees and scaled.
                    for (coefficient, over) in out.iter_mut().zip(INVERSE) {
                        *coefficient = y;
                        let by = omega * over;
                        (y, z) = (-by * z, by * y);
                    }
                    return out;
                }
                let (mut y_before, mut z_before) = (0.0, 0.0);
                for (k, coefficient) in out.iter_mut().enumerate() {
                    *coefficient = y;
                    let over = 1.0 / (k + 1) as f64;
                    let next = (-(omega * z + rate * z_before) * over, (omega * y + rate * y_before) * over);
                    (y_before, z_before) = (y, z);
                    (y, z) = next;
                }
            }
            Forcing::Line { value, slope } => {
                out[0] = value + slope * s;
                if let Some(first) = out.get_mut(1) {
                    *first = slope * unit;
                }
            }
        }
        out
    }
}

/// `1 / (k + 1)` for each coefficient index k of a series.
pub(crate) const INVERSE: [f64; 64] = {
    let mut inverse = [0.0; 64];
    let mut k = 0;
    while k < 64 {
        inverse[k] = 1.0 / (k + 1) as f64;
        k += 1;
    }
    inverse
};
