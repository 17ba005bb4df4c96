//! The problem of a contact study: motion, friction law and forcing, in SI units.
//!
//! ```text
//! kinematic:  x' = Vv w(t)                                        (no system dynamics)
//! SDOF:       m x'' + c x' + Ks x = F0 w(t) - F                   (thesis 4.14, 4.36; c is our
//!                                                                 addition)
//! slip:       V = Vt + x'   passive (4.2, 4.25, 4.27)
//!             V = Vt - x'   literal (4.16); here friction feeds energy into the oscillator
//! ```

use super::state::State;
use super::waveform::Waveform;

/// Friction over force amplitude above which friction can hold the mass still at times.
const HOLDING_FORCE_RATIO: f64 = 0.1;

/// Contact problem: motion, friction law, forcing and time span.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Motion of the contact in addition to the sliding.
    pub motion: Motion,
    /// Friction law of the contact.
    pub law: Law,
    /// Coulomb force Fc = mu N, N.
    pub coulomb_n: f64,
    /// Sliding speed Vt, m/s.
    pub sliding_m_per_s: f64,
    /// Sign of the vibration in the slip velocity.
    pub sign: Sign,
    /// Force on the oscillator, N. In a kinematic motion: the vibration velocity, m/s.
    pub waveform: Waveform,
    /// State at the beginning of the run.
    pub start: State,
    /// Changes of the Coulomb force: time, s, and new force, N, in ascending order of time.
    pub load_steps: Vec<(f64, f64)>,
    /// Window over which the means are taken: start and end, s.
    pub window_s: (f64, f64),
    /// End of the run, s.
    pub duration_s: f64,
}

/// Motion of the contact in addition to the sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Prescribed vibration velocity, without system dynamics.
    Kinematic,
    /// Single mass on a spring.
    Sdof {
        /// Mass m, kg.
        mass_kg: f64,
        /// Stiffness Ks, N/m.
        stiffness_n_per_m: f64,
        /// Damping c, N s/m.
        damping_n_s_per_m: f64,
    },
}

/// Friction law: relation between slip and force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// `F = Fc sgn V` (4.1).
    Coulomb,
    /// `dF/dt = Kt V (1 - (F / Fc) sgn V)`, exponent one (4.15).
    Dahl {
        /// Tangential stiffness Kt, N/m.
        stiffness_n_per_m: f64,
    },
    /// `z' = V - |V| z / G(V)`, `F = Kt z + sigma1 z' + sigma2 V`,
    /// `Kt G(V) = Fc (1 + (Fs/Fc - 1) exp(-(V/Vs)^2))` (4.7, 4.9, 4.10).
    Lugre {
        /// Bristle stiffness Kt, N/m.
        stiffness_n_per_m: f64,
        /// Static over kinetic friction, Fs / Fc.
        static_ratio: f64,
        /// Stribeck velocity Vs, m/s.
        stribeck_m_per_s: f64,
        /// Bristle damping, N s/m.
        sigma1: f64,
        /// Viscous friction, N s/m.
        sigma2: f64,
    },
}

impl Law {
    /// Returns the tangential stiffness Kt of the bristles, N/m; `None` for Coulomb's law.
    pub fn stiffness_n_per_m(&self) -> Option<f64> {
        match *self {
            Law::Coulomb => None,
            Law::Dahl { stiffness_n_per_m } | Law::Lugre { stiffness_n_per_m, .. } => Some(stiffness_n_per_m),
        }
    }
}

/// Sign of the vibration in the slip velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sign {
    /// `V = Vt + x'`: friction dissipates energy.
    #[default]
    Passive,
    /// `V = Vt - x'` with `- F` on the mass, as 4.14 and 4.16 are printed: friction feeds energy
    /// into the oscillator.
    Literal,
}

impl Sign {
    /// Returns the factor of x' in the slip velocity.
    pub fn factor(self) -> f64 {
        match self {
            Sign::Passive => 1.0,
            Sign::Literal => -1.0,
        }
    }
}

impl Motion {
    /// Returns the undamped natural frequency, Hz; `None` without dynamics.
    pub fn natural_hz(&self) -> Option<f64> {
        match *self {
            Motion::Kinematic => None,
            Motion::Sdof { mass_kg, stiffness_n_per_m, .. } => Some((stiffness_n_per_m / mass_kg).sqrt() / std::f64::consts::TAU),
        }
    }
}

impl Motion {
    /// Returns the fastest rate of the oscillator alone, Hz: the larger of its natural frequency
    /// and the damper's rate c / m over 2 pi.
    pub fn fastest_hz(&self) -> f64 {
        match *self {
            Motion::Kinematic => 0.0,
            Motion::Sdof { mass_kg, damping_n_s_per_m, .. } => {
                self.natural_hz().unwrap_or(0.0).max(damping_n_s_per_m / mass_kg / std::f64::consts::TAU)
            }
        }
    }
}

impl Problem {
    /// Returns the problem cut off at the end of its window, which is all that the means need.
    pub fn up_to_window(&self) -> Problem {
        Problem { duration_s: self.duration_s.min(self.window_s.1), ..self.clone() }
    }

    /// Returns the steady vibration velocity Vv of a sine of this amplitude and frequency without
    /// friction, m/s: `w F0 / |Ks - m w^2 + i w c|`.
    ///
    /// Infinite at an undamped resonance.
    pub fn vibration_m_per_s(&self) -> f64 {
        let omega = std::f64::consts::TAU * self.waveform.frequency_hz();
        match self.motion {
            Motion::Kinematic => self.waveform.amplitude(),
            Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } => {
                let reactance = stiffness_n_per_m - mass_kg * omega * omega;
                omega * self.waveform.amplitude() / reactance.hypot(omega * damping_n_s_per_m)
            }
        }
    }

    /// Returns `true` if friction is a large part of the force and so can hold the mass still at
    /// times.
    ///
    /// Friction here is the larger of the Coulomb force and the force of the bristles' damping,
    /// `sigma1 Vv`. Always `false` for a prescribed motion.
    pub fn holds(&self) -> bool {
        let damping_n_s_per_m = match self.law {
            Law::Lugre { sigma1, .. } => sigma1,
            _ => 0.0,
        };
        let friction_n = self.coulomb_n.max(damping_n_s_per_m * self.vibration_m_per_s());
        self.motion != Motion::Kinematic && friction_n > HOLDING_FORCE_RATIO * self.waveform.amplitude()
    }

    /// Returns `kappa = Kt Vv / (w Fc)`: the vibration amplitude in Dahl lengths. Infinite for
    /// Coulomb friction.
    pub fn kappa(&self) -> f64 {
        let omega = std::f64::consts::TAU * self.waveform.frequency_hz();
        let by = |stiffness_n_per_m: f64| stiffness_n_per_m * self.vibration_m_per_s() / (omega * self.coulomb_n);
        self.law.stiffness_n_per_m().map_or(f64::INFINITY, by)
    }
}
