//! The right-hand side that the Runge-Kutta methods share: motion, friction law, and the integrals
//! of the [`tally`](crate::tally).
//!
//! ```text
//! x' = v,   m v' = Fe - c v - Ks x - F,   V = Vt + s v                       (4.14, 4.16)
//! f' = (Kt / Fc) (V - |V| f / g(V)),      f = Kt z / Fc                       (4.15, 4.7)
//! g  = 1 + (Fs/Fc - 1) exp(-(V/Vs)^2),    F = Fc f + sigma1 z' + sigma2 V     (4.9, 4.10)
//! ```
//!
//! The caller provides `|V|`: from the slip itself, or from a sign that the caller keeps.

use crate::problem::{Law, Motion, Problem};
use crate::tally::{State, Totals};

/// Number of states of the thesis's solver: x, m; x', m/s; bristle force over Fc; integral of F, N
/// s.
pub const LEAN_STATES: usize = 4;

/// Number of states with all integrals of a tally: in addition F V, input and damper, J, and
/// kinetic and potential energy, J s.
pub const FULL_STATES: usize = 9;

/// Factor above the largest bristle force of the law at which a solution counts as diverged.
const ESCAPE_RATIO: f64 = 10.0;

/// Right-hand side of a problem at one Coulomb force.
#[derive(Clone, Copy, Debug)]
pub struct Rates {
    law: Law,
    motion: Motion,
    /// Sliding speed Vt, m/s.
    pub sliding_m_per_s: f64,
    /// Factor s of x' in the slip.
    pub sign: f64,
    /// Coulomb force Fc, N.
    pub coulomb_n: f64,
    /// Kt / Fc, 1/m.
    stiffness_per_force: f64,
    /// 1 / m, 1/kg.
    per_mass: f64,
    /// Bristle force over Fc beyond which the solution has diverged.
    limit: f64,
}

impl Rates {
    /// Creates the right-hand side at the beginning of a problem, and the state there.
    pub fn new<const N: usize>(problem: &Problem) -> (Self, [f64; N]) {
        let mut y = [0.0; N];
        (y[0], y[1], y[2]) = (problem.start.x_m, problem.start.v_m_per_s, problem.start.force_n / problem.coulomb_n);
        let per_mass = if let Motion::Sdof { mass_kg, .. } = problem.motion { 1.0 / mass_kg } else { 0.0 };
        let mut rates = Rates {
            law: problem.law,
            motion: problem.motion,
            sliding_m_per_s: problem.sliding_m_per_s,
            sign: problem.sign.factor(),
            coulomb_n: problem.coulomb_n,
            stiffness_per_force: 0.0,
            per_mass,
            limit: 0.0,
        };
        rates.load(&mut y, problem.coulomb_n);
        (rates, y)
    }

    /// Changes the Coulomb force, N; the force in the bristles stays.
    pub fn load<const N: usize>(&mut self, y: &mut [f64; N], coulomb_n: f64) {
        y[2] *= self.coulomb_n / coulomb_n;
        self.coulomb_n = coulomb_n;
        let (stiffness, largest) = match self.law {
            Law::Coulomb => (0.0, 1.0),
            Law::Dahl { stiffness_n_per_m } => (stiffness_n_per_m, 1.0),
            Law::Lugre { stiffness_n_per_m, static_ratio, .. } => (stiffness_n_per_m, static_ratio.max(1.0)),
        };
        self.stiffness_per_force = stiffness / coulomb_n;
        self.limit = ESCAPE_RATIO * y[2].abs().max(largest);
    }

    /// Returns `true` if the state has diverged.
    #[inline]
    pub fn escaped<const N: usize>(&self, y: &[f64; N]) -> bool {
        y[2].abs() > self.limit || !y.iter().all(|value| value.is_finite())
    }

    /// Returns the vibration velocity x', m/s.
    #[inline]
    pub fn velocity<const N: usize>(&self, y: &[f64; N], forcing: f64) -> f64 {
        if matches!(self.motion, Motion::Kinematic) { forcing } else { y[1] }
    }

    /// Returns the slip velocity V for a vibration velocity, m/s.
    #[inline]
    pub fn slip(&self, v: f64) -> f64 {
        self.sliding_m_per_s + self.sign * v
    }

    /// Returns friction, N, and the rate of the bristle force over Fc, 1/s, at a slip velocity and
    /// its absolute value.
    #[inline]
    pub fn friction(&self, bristle: f64, slip: f64, size: f64) -> (f64, f64) {
        match self.law {
            Law::Coulomb => (self.coulomb_n * slip.signum(), 0.0),
            Law::Dahl { .. } => (self.coulomb_n * bristle, self.stiffness_per_force * (slip - size * bristle)),
            Law::Lugre { static_ratio, stribeck_m_per_s, sigma1, sigma2, .. } => {
                let z_rate = slip - size * bristle / level(static_ratio, stribeck_m_per_s, slip);
                let rate = self.stiffness_per_force * z_rate;
                (self.coulomb_n * bristle + sigma1 * z_rate + sigma2 * slip, rate)
            }
        }
    }

    /// Returns the rates of all states under a forcing, N or m/s. `size` computes `|V|` from V.
    #[inline]
    pub fn derivatives<const N: usize>(&self, y: &[f64; N], forcing: f64, size: impl Fn(f64) -> f64) -> [f64; N] {
        let v = self.velocity(y, forcing);
        let slip = self.slip(v);
        let (force, bristle_rate) = self.friction(y[2], slip, size(slip));
        let mut rate = [0.0; N];
        (rate[0], rate[2], rate[3]) = (v, bristle_rate, force);
        if N == FULL_STATES {
            (rate[4], rate[5]) = (force * slip, force * v);
        }
        if let Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m: c } = self.motion {
            rate[1] = (forcing - c * v - stiffness_n_per_m * y[0] - force) * self.per_mass;
            if N == FULL_STATES {
                (rate[5], rate[6]) = (forcing * v, c * v * v);
                (rate[7], rate[8]) = (0.5 * mass_kg * v * v, 0.5 * stiffness_n_per_m * y[0] * y[0]);
            }
        }
        rate
    }

    /// Advances `y`, whose rates are `first`, by one classical Runge-Kutta step of `h` seconds,
    /// with the forcing in its middle and at its end.
    #[inline]
    pub fn step<const N: usize>(
        &self,
        y: &[f64; N],
        first: &[f64; N],
        h: f64,
        forcing: (f64, f64),
        size: impl Fn(f64) -> f64 + Copy,
    ) -> [f64; N] {
        let along = |k: &[f64; N], part: f64| std::array::from_fn(|i| y[i] + part * h * k[i]);
        let k2 = self.derivatives(&along(first, 0.5), forcing.0, size);
        let k3 = self.derivatives(&along(&k2, 0.5), forcing.0, size);
        let k4 = self.derivatives(&along(&k3, 1.0), forcing.1, size);
        std::array::from_fn(|i| y[i] + h / 6.0 * (first[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
    }

    /// Returns the state for observers.
    #[inline]
    pub fn state<const N: usize>(&self, y: &[f64; N], forcing: f64, time_s: f64) -> State {
        let v = self.velocity(y, forcing);
        let slip = self.slip(v);
        State { time_s, x_m: y[0], v_m_per_s: v, force_n: self.friction(y[2], slip, slip.abs()).0 }
    }
}

/// Returns `g = Kt G / Fc` of LuGre's law at a slip velocity (4.9): Fs / Fc at rest, falling to
/// one.
#[inline]
pub fn level(static_ratio: f64, stribeck_m_per_s: f64, slip: f64) -> f64 {
    let ratio = slip / stribeck_m_per_s;
    1.0 + (static_ratio - 1.0) * (-ratio * ratio).exp()
}

/// Returns the integrals since the beginning; from a lean state only that of friction.
#[inline]
pub fn totals<const N: usize>(y: &[f64; N]) -> Totals {
    let of = |index: usize| y.get(index).copied().unwrap_or(0.0);
    Totals {
        friction_n_s: y[3],
        friction_work_j: of(4),
        felt_n_s: y[3],
        felt_work_j: of(4),
        input_j: of(5),
        damping_j: of(6),
        kinetic_j_s: of(7),
        potential_j_s: of(8),
    }
}
