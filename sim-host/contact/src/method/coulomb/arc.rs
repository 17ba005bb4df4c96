//! One smooth piece of a motion, as power series in its elapsed fraction (0 to 1).
//!
//! For constant F, `m x'' + c x' + Ks x = Fe - F` gives, with the length L of the piece,
//!
//! ```text
//! (k + 1) (k + 2) x_{k+2} = L^2 / m (Fe_k - F_k) - L c / m (k + 1) x_{k+1} - L^2 Ks / m x_k
//! ```

use crate::problem::Motion;
use crate::state::State;

/// Number of terms of a series.
pub(super) const TERMS: usize = 22;

type Series = [f64; TERMS];

/// Smooth piece of a motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    /// Length, s.
    pub(super) length: f64,
    /// Force on the oscillator, N, or given velocity, m/s.
    pub(super) forcing: Series,
    /// Displacement x, m.
    pub(super) place: Series,
    /// Velocity x', m/s.
    pub(super) velocity: Series,
    /// Friction, N.
    pub(super) friction: Series,
}

/// Converts Taylor coefficients in time into powers of the fraction of a length.
pub(super) fn scaled(coefficients: Series, length: f64) -> Series {
    let mut power = 1.0;
    coefficients.map(|c| {
        let out = c * power;
        power *= length;
        out
    })
}

impl Arc {
    /// Computes a piece with a given velocity.
    pub(super) fn given(velocity: &Series, length: f64, from: &State, friction_n: f64) -> Self {
        let mut place = [0.0; TERMS];
        place[0] = from.x_m;
        for k in 1..TERMS {
            place[k] = length * velocity[k - 1] / k as f64;
        }
        Arc { length, forcing: *velocity, place, velocity: *velocity, friction: constant(friction_n) }
    }

    /// Computes a piece of an oscillator with constant friction; a kinematic motion has no such
    /// piece.
    pub(super) fn free(motion: Motion, forcing: &Series, length: f64, from: &State, friction_n: f64) -> Self {
        let mut place = [0.0; TERMS];
        (place[0], place[1]) = (from.x_m, length * from.v_m_per_s);
        if let Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } = motion {
            let force = length * length / mass_kg;
            let (drag, spring) = (length * damping_n_s_per_m / mass_kg, force * stiffness_n_per_m);
            for k in 0..TERMS - 2 {
                let (k1, k2) = ((k + 1) as f64, (k + 2) as f64);
                let friction = if k == 0 { friction_n } else { 0.0 };
                place[k + 2] = (force * (forcing[k] - friction) - drag * k1 * place[k + 1] - spring * place[k]) / (k1 * k2);
            }
        }
        let mut velocity = [0.0; TERMS];
        for k in 1..TERMS {
            velocity[k - 1] = k as f64 * place[k] / length;
        }
        Arc { length, forcing: *forcing, place, velocity, friction: constant(friction_n) }
    }

    /// Computes a piece of an oscillator that the contact holds: its velocity is constant, and
    /// friction balances the other forces.
    pub(super) fn held(motion: Motion, forcing: &Series, length: f64, from: &State) -> Self {
        let (mut place, mut friction) = ([0.0; TERMS], *forcing);
        (place[0], place[1]) = (from.x_m, length * from.v_m_per_s);
        if let Motion::Sdof { stiffness_n_per_m, damping_n_s_per_m, .. } = motion {
            friction[0] -= damping_n_s_per_m * from.v_m_per_s + stiffness_n_per_m * place[0];
            friction[1] -= stiffness_n_per_m * place[1];
        }
        Arc { length, forcing: *forcing, place, velocity: constant(from.v_m_per_s), friction }
    }

    /// Returns x, x' and friction at the fraction `part` of the piece.
    pub(super) fn at(&self, part: f64) -> (f64, f64, f64) {
        (value(&self.place, part), value(&self.velocity, part), value(&self.friction, part))
    }

    /// Returns the integral of friction over the fraction `part` of the piece, N s.
    pub(super) fn impulse(&self, part: f64) -> f64 {
        self.length * integral(&self.friction, part)
    }
}

fn constant(value: f64) -> Series {
    let mut out = [0.0; TERMS];
    out[0] = value;
    out
}

/// Returns the value of a series at the fraction `part`.
pub(super) fn value(series: &[f64], part: f64) -> f64 {
    series.iter().rev().fold(0.0, |sum, c| sum * part + c)
}

fn integral(series: &Series, part: f64) -> f64 {
    let mut k = TERMS as f64 + 1.0;
    part * series.iter().rev().fold(0.0, |sum, c| {
        k -= 1.0;
        sum * part + c / k
    })
}

/// Returns the integral of the product of two series from 0 to `part`.
pub(super) fn product(a: &Series, b: &Series, part: f64) -> f64 {
    let terms = std::array::from_fn(|k| a[..=k].iter().zip(b[..=k].iter().rev()).map(|(a, b)| a * b).sum());
    integral(&terms, part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_integrate_as_their_functions() {
        // exp on [0, part]: the integral is exp - 1, that of its square (exp(2 part) - 1) / 2.
        let mut term = 1.0;
        let exponential: Series = std::array::from_fn(|k| {
            let out = term;
            term *= 0.8 / (k + 1) as f64;
            out
        });
        let part = 0.7;
        assert!((integral(&exponential, part) - (0.56f64.exp() - 1.0) / 0.8).abs() < 5e-16);
        assert!((product(&exponential, &exponential, part) - (1.12f64.exp() - 1.0) / 1.6).abs() < 1e-15);
    }
}
