//! Table 4.1 and the problems based on it.
//!
//! Choices that the table leaves open: gravity, a start from rest, and means over the whole run
//! unless a study states otherwise.

use contact::{Law, Motion, Problem, Shape, Sign, State, Waveform, table_4_1};

/// Acceleration of gravity, m/s^2.
pub const GRAVITY_M_PER_S2: f64 = 9.81;
/// Length of a run from rest, s: sixty periods. The thesis gives neither a simulation time nor an
/// averaging window.
pub const SHORT_S: f64 = 1e-3;
/// Control force of the thesis's time and frequency plots, N (4.3.1).
pub const PLOTTED_FORCE_N: f64 = table_4_1::FORCE_N;
/// Velocity ratio of the thesis's time plots (4.3.1).
pub const PLOTTED_RATIO: f64 = 0.5;
/// Largest control force, N (Table 4.1).
pub const LARGEST_FORCE_N: f64 = 1920.0;
/// Fixed step of the thesis's solver, s (Table 4.1).
pub const STEP_S: f64 = 1.667e-8;

/// One set of parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Mass m of the oscillator, kg.
    pub mass_kg: f64,
    /// System stiffness Ks, N/m.
    pub stiffness_n_per_m: f64,
    /// Structural damping ratio; zero in the thesis.
    pub damping_ratio: f64,
    /// Frequency of the excitation, Hz.
    pub frequency_hz: f64,
    /// Control force, peak, N.
    pub force_n: f64,
    /// Tangential contact stiffness Kt, N/m.
    pub contact_n_per_m: f64,
    /// Coefficient of friction of the contact.
    pub mu: f64,
    /// Sign of the vibration in the slip.
    pub sign: Sign,
}

/// Table 4.1 with the control force of the thesis's time plots.
pub const TABLE_4_1: Case = Case {
    mass_kg: table_4_1::MASS_KG,
    stiffness_n_per_m: table_4_1::STIFFNESS_N_PER_M,
    damping_ratio: 0.0,
    frequency_hz: table_4_1::DRIVE_HZ,
    force_n: PLOTTED_FORCE_N,
    contact_n_per_m: table_4_1::CONTACT_N_PER_M,
    mu: 0.1,
    sign: Sign::Passive,
};

impl Case {
    /// Returns the problem without excitation; the mass starts with a velocity, m/s.
    pub fn unexcited(&self, start_m_per_s: f64, sliding_m_per_s: f64, duration_s: f64) -> Problem {
        let mut problem = Case { force_n: 0.0, ..*self }.oscillator(Shape::Still, sliding_m_per_s, duration_s);
        problem.start.v_m_per_s = start_m_per_s;
        problem
    }

    /// Returns the Coulomb force Fc = mu m g, N.
    pub fn coulomb_n(&self) -> f64 {
        self.mu * self.mass_kg * GRAVITY_M_PER_S2
    }

    /// Returns the natural frequency of the oscillator, Hz.
    pub fn natural_hz(&self) -> f64 {
        self.natural_rad_per_s() / std::f64::consts::TAU
    }

    /// Returns the natural frequency of the oscillator, rad/s.
    pub fn natural_rad_per_s(&self) -> f64 {
        (self.stiffness_n_per_m / self.mass_kg).sqrt()
    }

    /// Returns the frequency of the excitation, rad/s.
    pub fn omega(&self) -> f64 {
        std::f64::consts::TAU * self.frequency_hz
    }

    /// Returns the steady vibration velocity Vv under the sine, without friction, m/s.
    pub fn vibration_m_per_s(&self) -> f64 {
        self.oscillator(Shape::Sine, 0.0, SHORT_S).vibration_m_per_s()
    }

    /// Returns the vibration amplitude in Dahl lengths.
    pub fn kappa(&self) -> f64 {
        self.oscillator(Shape::Sine, 0.0, SHORT_S).kappa()
    }

    /// Returns the mass on its spring (4.14, 4.36), from rest, with means over the whole run.
    pub fn oscillator(&self, shape: Shape, sliding_m_per_s: f64, duration_s: f64) -> Problem {
        let damping_n_s_per_m = 2.0 * self.damping_ratio * (self.stiffness_n_per_m * self.mass_kg).sqrt();
        let motion = Motion::Sdof { mass_kg: self.mass_kg, stiffness_n_per_m: self.stiffness_n_per_m, damping_n_s_per_m };
        self.problem(motion, Waveform::new(shape, self.force_n, self.frequency_hz, duration_s), sliding_m_per_s, duration_s)
    }

    /// Returns the problem with the sine, at a velocity ratio relative to the steady vibration
    /// velocity of this case.
    pub fn at_ratio(&self, velocity_ratio: f64, duration_s: f64) -> Problem {
        self.oscillator(Shape::Sine, velocity_ratio * self.vibration_m_per_s(), duration_s)
    }

    /// Returns the problem with a prescribed vibration velocity of the given peak, m/s (no system
    /// dynamics), and means over the whole run.
    pub fn kinematic(&self, shape: Shape, peak_m_per_s: f64, sliding_m_per_s: f64, duration_s: f64) -> Problem {
        let waveform = Waveform::new(shape, peak_m_per_s, self.frequency_hz, duration_s);
        self.problem(Motion::Kinematic, waveform, sliding_m_per_s, duration_s)
    }

    fn problem(&self, motion: Motion, waveform: Waveform, sliding_m_per_s: f64, duration_s: f64) -> Problem {
        Problem {
            motion,
            law: Law::Dahl { stiffness_n_per_m: self.contact_n_per_m },
            coulomb_n: self.coulomb_n(),
            sliding_m_per_s,
            sign: self.sign,
            waveform,
            start: State::default(),
            load_steps: Vec::new(),
            window_s: (0.0, duration_s),
            duration_s,
        }
    }
}
