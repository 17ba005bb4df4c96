//! The linear part of a problem: the motion from a state under a given forcing, without friction.
//!
//! ```text
//! SDOF:       x'' + 2 d x' + w^2 x = u(t)       d = c / 2m,  w^2 = Ks / m,  u = force / m
//! kinematic:  x' = u(t)
//! ```
//!
//! The flow is exact for any forcing given by its Taylor coefficients. It does not use a particular
//! solution `F0 / (Ks - m W^2)`, so resonance is not a special case.

use crate::forcing::Forcing;
use crate::problem::{Motion, Problem};

/// Linear part of a problem.
#[derive(Clone, Copy, Debug)]
pub struct Oscillator {
    /// `true` if the velocity is given instead of integrated.
    pub kinematic: bool,
    /// One over the mass, 1/kg; one in a kinematic motion.
    pub per_mass: f64,
    /// c / m, 1/s.
    pub damping: f64,
    /// Ks / m, 1/s^2.
    pub stiffness: f64,
}

/// Number of coefficients in the response to a kick. Kicks contain only the third and higher terms
/// of friction over a step h, so the truncation error is of order h^11.
pub const KERNEL: usize = 8;

impl Oscillator {
    /// Returns the oscillator of a problem.
    pub fn new(problem: &Problem) -> Self {
        match problem.motion {
            Motion::Kinematic => Oscillator { kinematic: true, per_mass: 1.0, damping: 0.0, stiffness: 0.0 },
            Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } => Oscillator {
                kinematic: false,
                per_mass: 1.0 / mass_kg,
                damping: damping_n_s_per_m / mass_kg,
                stiffness: stiffness_n_per_m / mass_kg,
            },
        }
    }

    /// Returns the coefficients of the forcing over `unit` seconds from `at_s`: an acceleration,
    /// m/s^2, or a velocity, m/s.
    #[inline]
    pub fn forcing<const N: usize>(&self, forcing: &Forcing, at_s: f64, unit: f64) -> [f64; N] {
        let mut u = forcing.taylor_in(at_s, unit);
        u.iter_mut().for_each(|c| *c *= self.per_mass);
        u
    }

    /// Returns the coefficients of displacement and velocity over `unit` seconds, from `x` and `v`
    /// under the forcing `u`.
    #[inline]
    pub fn series<const N: usize>(&self, x: f64, v: f64, u: &[f64; N], unit: f64) -> ([f64; N], [f64; N]) {
        let (mut xs, mut vs) = ([0.0; N], [0.0; N]);
        xs[0] = x;
        if self.kinematic {
            vs = *u;
            for k in 1..N {
                xs[k] = unit * vs[k - 1] * INVERSE[k];
            }
            return (xs, vs);
        }
        vs[0] = v;
        for k in 1..N {
            let scale = unit * INVERSE[k];
            vs[k] = scale * (u[k - 1] - self.damping * vs[k - 1] - self.stiffness * xs[k - 1]);
            xs[k] = scale * vs[k - 1];
        }
        (xs, vs)
    }

    /// Returns the displacement after a kick that changes the velocity by one, as coefficients of
    /// the time since the kick, s.
    pub fn kernel(&self) -> [f64; KERNEL] {
        if self.kinematic { [0.0; KERNEL] } else { self.series(0.0, 1.0, &[0.0; KERNEL], 1.0).0 }
    }
}

/// Largest number of coefficients of a series.
const LARGEST: usize = 34;
/// Reciprocal of each index.
pub(super) const INVERSE: [f64; LARGEST] = {
    let mut inverse = [0.0; LARGEST];
    let mut k = 1;
    while k < LARGEST {
        inverse[k] = 1.0 / k as f64;
        k += 1;
    }
    inverse
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::polynomial::value;

    #[test]
    fn undamped_resonance_grows_by_half_f_t_over_m() {
        // From rest under cos(w t): v = (sin(w t) + w t cos(w t)) / 2w, exactly.
        let w = 3.0;
        let oscillator = Oscillator { kinematic: false, per_mass: 1.0, damping: 0.0, stiffness: w * w };
        let (mut x, mut v, h) = (0.0, 0.0, 0.05);
        for step in 0..20_000 {
            let turns = w * h * f64::from(step) / std::f64::consts::TAU;
            let forcing = Forcing::Cosine { size: 1.0, turns, hz: w / std::f64::consts::TAU, hz_per_s: 0.0 };
            let u: [f64; 14] = oscillator.forcing(&forcing, 0.0, h);
            let (xs, vs) = oscillator.series(x, v, &u, h);
            (x, v) = (value(&xs, 1.0), value(&vs, 1.0));
        }
        let t: f64 = 20_000.0 * h;
        let exact = ((w * t).sin() + w * t * (w * t).cos()) / (2.0 * w);
        assert!((v - exact).abs() < 1e-9 * t, "{v} {exact}");
    }

    #[test]
    fn a_kick_is_answered_by_a_decaying_sine() {
        let oscillator = Oscillator { kinematic: false, per_mass: 1.0, damping: 0.2, stiffness: 4.0 };
        let damped = (4.0f64 - 0.01).sqrt();
        let t: f64 = 0.15;
        let exact = (-0.1 * t).exp() * (damped * t).sin() / damped;
        let error = value(&oscillator.kernel(), t) / exact - 1.0;
        assert!(error.abs() < 1e-8, "{error:e}");
    }
}
