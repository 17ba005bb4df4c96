//! The thesis's Table 4.1 as a problem: 384 N at 60 kHz, passive sign, from rest. Reference case
//! for speed and error.

use super::{Law, Motion, Problem, Shape, Sign, State, Waveform};

/// Drive frequency of Table 4.1, Hz.
pub const DRIVE_HZ: f64 = 60e3;
/// Peak drive force of Table 4.1, N.
pub const FORCE_N: f64 = 384.0;
/// Mass of the oscillator of Table 4.1, kg.
pub const MASS_KG: f64 = 0.02;
/// Stiffness Ks of the oscillator of Table 4.1, N/m.
pub const STIFFNESS_N_PER_M: f64 = 133e6;
/// Tangential stiffness Kt of the contact of Table 4.1, N/m.
pub const CONTACT_N_PER_M: f64 = 0.056e6;
/// Coulomb force mu m g of Table 4.1, N.
pub const COULOMB_N: f64 = 0.1 * MASS_KG * 9.81;
/// Velocity ratio Vt / Vv of the standard case.
pub const VELOCITY_RATIO: f64 = 0.5;
/// Number of drive periods of the standard case; the means are over the second half.
pub const PERIODS: f64 = 200.0;

/// Returns Table 4.1 at a velocity ratio over a number of drive periods; the means are over the
/// second half.
pub fn table_4_1(velocity_ratio: f64, periods: f64) -> Problem {
    let mut problem = Problem {
        motion: Motion::Sdof { mass_kg: MASS_KG, stiffness_n_per_m: STIFFNESS_N_PER_M, damping_n_s_per_m: 0.0 },
        law: Law::Dahl { stiffness_n_per_m: CONTACT_N_PER_M },
        coulomb_n: COULOMB_N,
        sliding_m_per_s: 0.0,
        sign: Sign::Passive,
        waveform: Waveform::new(Shape::Sine, FORCE_N, DRIVE_HZ, periods / DRIVE_HZ),
        start: State::default(),
        load_steps: Vec::new(),
        window_s: (0.5 * periods / DRIVE_HZ, periods / DRIVE_HZ),
        duration_s: periods / DRIVE_HZ,
    };
    problem.sliding_m_per_s = velocity_ratio * problem.vibration_m_per_s();
    problem
}

/// Returns the contact problem of Table 4.1 with its standard values.
pub fn standard() -> Problem {
    table_4_1(VELOCITY_RATIO, PERIODS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derived_quantities() {
        let problem = table_4_1(0.5, 10.0);
        assert!((problem.vibration_m_per_s() - 0.053_429_6).abs() < 1e-7);
        assert!((problem.kappa() - 0.404_52).abs() < 1e-5);
        assert!((problem.motion.natural_hz().unwrap() - 12_978.69).abs() < 0.01);
    }
}
