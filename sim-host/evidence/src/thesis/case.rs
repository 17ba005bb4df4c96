//! Table 4.1, and the problems that are made of it.
//!
//! What the table leaves open is settled here: gravity, and a start from rest with the means over the whole run unless a study says
//! otherwise.

use contact::{Law, Motion, Problem, Shape, Sign, State, Waveform, table_4_1};

/// Acceleration of gravity, m/s^2.
pub const GRAVITY: f64 = 9.81;
/// Length of a run from rest, s: sixty periods. The thesis names neither a simulation time nor an averaging window.
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
    /// Structural damping ratio; the thesis has none.
    pub damping_ratio: f64,
    /// Frequency of the excitation, Hz.
    pub frequency_hz: f64,
    /// Control force, peak, N.
    pub force_n: f64,
    /// Tangential contact stiffness Kt, N/m.
    pub contact_n_per_m: f64,
    /// Coefficient of friction of the contact.
    pub mu: f64,
    /// Which way the vibration counts in the slip.
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
    /// Nothing but friction acts; the mass begins with a velocity, m/s.
    pub fn unexcited(&self, start_m_per_s: f64, sliding_m_per_s: f64, duration_s: f64) -> Problem {
        let mut problem = Case { force_n: 0.0, ..*self }.oscillator(Shape::Still, sliding_m_per_s, duration_s);
        problem.start.v_m_per_s = start_m_per_s;
        problem
    }

    /// Coulomb force Fc = mu m g, N.
    pub fn coulomb_n(&self) -> f64 {
        self.mu * self.mass_kg * GRAVITY
    }

    /// Natural frequency of the oscillator, Hz.
    pub fn natural_hz(&self) -> f64 {
        self.natural_rad_per_s() / std::f64::consts::TAU
    }

    /// Natural frequency of the oscillator, rad/s.
    pub fn natural_rad_per_s(&self) -> f64 {
        (self.stiffness_n_per_m / self.mass_kg).sqrt()
    }

    /// Frequency of the excitation, rad/s.
    pub fn omega(&self) -> f64 {
        std::f64::consts::TAU * self.frequency_hz
    }

    /// Steady vibration velocity Vv under the sine, friction apart, m/s.
    pub fn vibration_m_per_s(&self) -> f64 {
        self.oscillator(Shape::Sine, 0.0, SHORT_S).vibration_m_per_s()
    }

    /// Vibration amplitude in Dahl lengths.
    pub fn kappa(&self) -> f64 {
        self.oscillator(Shape::Sine, 0.0, SHORT_S).kappa()
    }

    /// The mass on its spring (4.14, 4.36), from rest, means over the whole run.
    pub fn oscillator(&self, shape: Shape, sliding_m_per_s: f64, duration_s: f64) -> Problem {
        let damping_n_s_per_m = 2.0 * self.damping_ratio * (self.stiffness_n_per_m * self.mass_kg).sqrt();
        let motion = Motion::Sdof { mass_kg: self.mass_kg, stiffness_n_per_m: self.stiffness_n_per_m, damping_n_s_per_m };
        self.problem(motion, Waveform::new(shape, self.force_n, self.frequency_hz, duration_s), sliding_m_per_s, duration_s)
    }

    /// The problem with the sine, at a velocity ratio by the steady vibration velocity of this case.
    pub fn at_ratio(&self, velocity_ratio: f64, duration_s: f64) -> Problem {
        self.oscillator(Shape::Sine, velocity_ratio * self.vibration_m_per_s(), duration_s)
    }

    /// A vibration velocity of a peak, m/s, that is given (no system dynamics); means over the whole run.
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
