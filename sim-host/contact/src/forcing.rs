//! The forcing within a smooth piece: a cosine of linearly changing frequency, or a straight line.

use std::f64::consts::TAU;

/// The forcing within a piece, as a function of the time since its beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Forcing {
    /// `size cos(2 pi (turns + hz s + hz_per_s s^2 / 2))`.
    Cosine {
        /// Peak.
        size: f64,
        /// Phase at the beginning, turns.
        turns: f64,
        /// Frequency at the beginning, Hz.
        hz: f64,
        /// Its slope, Hz/s.
        hz_per_s: f64,
    },
    /// `value + slope s`.
    Line {
        /// At the beginning.
        value: f64,
        /// Per second.
        slope: f64,
    },
}

impl Forcing {
    /// The forcing `s` seconds after the beginning.
    pub fn value(&self, s: f64) -> f64 {
        match *self {
            Forcing::Cosine { size, turns, hz, hz_per_s } => size * (TAU * (turns + s * (hz + 0.5 * hz_per_s * s))).cos(),
            Forcing::Line { value, slope } => value + slope * s,
        }
    }

    /// The forcing with its time counted from `s` seconds after its beginning.
    pub fn later(&self, s: f64) -> Forcing {
        match *self {
            Forcing::Cosine { size, turns, hz, hz_per_s } => {
                let turns = turns + s * (hz + 0.5 * hz_per_s * s);
                Forcing::Cosine { size, turns, hz: hz + hz_per_s * s, hz_per_s }
            }
            Forcing::Line { value, slope } => Forcing::Line { value: value + slope * s, slope },
        }
    }

    /// Largest frequency within `length_s` seconds from the beginning, Hz; none of a line.
    pub fn fastest_hz(&self, length_s: f64) -> Option<f64> {
        match *self {
            Forcing::Cosine { hz, hz_per_s, .. } => Some(hz.max(hz + hz_per_s * length_s)),
            Forcing::Line { .. } => None,
        }
    }

    /// Taylor coefficients about `s`: the forcing at `s + d` is the sum of `out[k] d^k`.
    pub fn taylor<const N: usize>(&self, s: f64) -> [f64; N] {
        self.taylor_in(s, 1.0)
    }

    /// Taylor coefficients about `s` in units of `unit` seconds: the forcing at `s + d unit` is the sum of `out[k] d^k`.
    ///
    /// Of a cosine with phase p and p' = w + r d: y = cos p, z = sin p, (k+1) y_{k+1} = -(w z_k + r z_{k-1}),
    /// (k+1) z_{k+1} = w y_k + r y_{k-1}.
    pub fn taylor_in<const N: usize>(&self, s: f64, unit: f64) -> [f64; N] {
        let mut out = [0.0; N];
        match *self {
            Forcing::Cosine { size, turns, hz, hz_per_s } => {
                let (omega, rate) = (TAU * (hz + hz_per_s * s) * unit, TAU * hz_per_s * unit * unit);
                let (sine, cosine) = (TAU * (turns + s * (hz + 0.5 * hz_per_s * s))).sin_cos();
                let (mut y, mut z) = (size * cosine, size * sine);
                if rate == 0.0 {
                    // Without a slope each coefficient is the quarter turn of the one before.
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

/// One over the number of the next coefficient.
pub(crate) const INVERSE: [f64; 64] = {
    let mut inverse = [0.0; 64];
    let mut k = 0;
    while k < 64 {
        inverse[k] = 1.0 / (k + 1) as f64;
        k += 1;
    }
    inverse
};
