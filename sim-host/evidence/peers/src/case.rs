//! The cases that all peers solve: one mass, one spring and a contact, from rest, under a force of
//! 384 N (thesis, Table 4.1).
//!
//! | case | content |
//! |---|---|
//! | ordinary | Table 4.1: Dahl friction, a weak perturbation of the motion |
//! | strong | a contact as stiff as the mass's inertia, Kt = m w^2, and friction that is a quarter of the force needed to move the mass |
//! | LuGre | Table 4.1 with bristle damping, viscous friction and a Stribeck peak of 1 mm/s, a fiftieth of the vibration |
//! | chirp | Table 4.1 with a force that sweeps from 40 to 80 kHz |
//!
//! Peers of this project receive a case in SI units, as a [`Problem`]; all others receive its
//! [`Scaled`] coefficients.

use std::f64::consts::TAU;

use contact::table_4_1::{DRIVE_HZ, FORCE_N, MASS_KG, STIFFNESS_N_PER_M, VELOCITY_RATIO, table_4_1};
use contact::{Law, Problem, Shape, Waveform};

use crate::scaled::Scaled;

/// Kind of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    /// Table 4.1.
    Ordinary,
    /// Friction that governs the motion.
    Strong,
    /// A narrow Stribeck peak.
    Lugre,
    /// A sweep of the frequency.
    Chirp,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 4] = [Kind::Ordinary, Kind::Strong, Kind::Lugre, Kind::Chirp];

    /// Returns the name of the case.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Ordinary => "ordinary coupling",
            Kind::Strong => "strong coupling",
            Kind::Lugre => "LuGre with Stribeck",
            Kind::Chirp => "chirp",
        }
    }

    /// Returns the name as part of a file name.
    pub fn stem(self) -> &'static str {
        match self {
            Kind::Ordinary => "ordinary",
            Kind::Strong => "strong",
            Kind::Lugre => "lugre",
            Kind::Chirp => "chirp",
        }
    }
}

/// Vibration amplitude in Dahl lengths, strong coupling.
const STRONG_KAPPA: f64 = 4.0;
/// Fs / Fc of LuGre's friction.
const STATIC_RATIO: f64 = 1.5;
/// Stribeck velocity, m/s.
const STRIBECK_M_PER_S: f64 = 1e-3;
/// Bristle damping, N s/m: a quarter of Fc at the velocity of the vibration.
const SIGMA1: f64 = 0.1;
/// Viscous friction, N s/m.
const SIGMA2: f64 = 0.01;
/// First and last frequency of the chirp, Hz.
const CHIRP_HZ: (f64, f64) = (40e3, 80e3);

/// A case over a number of periods.
#[derive(Clone, Debug)]
pub struct Case {
    /// Kind of the case.
    pub kind: Kind,
    /// Length of the run in periods of 60 kHz; even, so that the averaging window begins with a
    /// period.
    pub periods: u32,
    /// The problem in SI units; the mean is over the second half.
    pub problem: Problem,
    /// The equations in units of order one.
    pub scaled: Scaled,
}

impl Case {
    /// Builds a case over `periods` periods.
    pub fn new(kind: Kind, periods: u32) -> Self {
        let periods = periods.max(2).next_multiple_of(2);
        let mut problem = table_4_1(VELOCITY_RATIO, f64::from(periods));
        let omega = TAU * DRIVE_HZ;
        let vibration = problem.vibration_m_per_s();
        let (mut start, mut rate) = (1.0, 0.0);
        match kind {
            Kind::Ordinary => {}
            Kind::Strong => {
                let stiffness_n_per_m = MASS_KG * omega * omega;
                problem.law = Law::Dahl { stiffness_n_per_m };
                problem.coulomb_n = stiffness_n_per_m * vibration / (omega * STRONG_KAPPA);
            }
            Kind::Lugre => {
                problem.law = Law::Lugre {
                    stiffness_n_per_m: contact::table_4_1::CONTACT_N_PER_M,
                    static_ratio: STATIC_RATIO,
                    stribeck_m_per_s: STRIBECK_M_PER_S,
                    sigma1: SIGMA1,
                    sigma2: SIGMA2,
                };
            }
            Kind::Chirp => {
                let (start_hz, stop_hz) = CHIRP_HZ;
                let sweep_s = problem.duration_s;
                problem.waveform = Waveform::new(Shape::Chirp { start_hz, stop_hz, sweep_s }, FORCE_N, DRIVE_HZ, sweep_s);
                start = start_hz / DRIVE_HZ;
                rate = (stop_hz - start_hz) / DRIVE_HZ / (TAU * f64::from(periods));
            }
        }
        let momentum_rate_n = MASS_KG * omega * vibration;
        let mut scaled = Scaled {
            sliding: VELOCITY_RATIO,
            kappa: 0.0,
            spring: STIFFNESS_N_PER_M / (MASS_KG * omega * omega),
            forcing: FORCE_N / momentum_rate_n,
            friction: problem.coulomb_n / momentum_rate_n,
            share: 1.0 / (TAU * f64::from(periods)),
            excess: 0.0,
            stribeck: 1.0,
            damping: 0.0,
            viscous: 0.0,
            start,
            rate,
        };
        if let Some(stiffness) = problem.law.stiffness_n_per_m() {
            scaled.kappa = stiffness * vibration / (omega * problem.coulomb_n);
            if let Law::Lugre { static_ratio, stribeck_m_per_s, sigma1, sigma2, .. } = problem.law {
                scaled.excess = static_ratio - 1.0;
                scaled.stribeck = stribeck_m_per_s / vibration;
                scaled.damping = sigma1 * omega / stiffness;
                scaled.viscous = sigma2 * vibration / problem.coulomb_n;
            }
        }
        Case { kind, periods, problem, scaled }
    }

    /// Returns the length of the run in scaled units.
    pub fn length(&self) -> f64 {
        TAU * f64::from(self.periods)
    }

    /// Returns the beginning and the end of the averaging window, which ends with the run.
    pub fn marks(&self) -> [f64; 2] {
        [0.5 * self.length(), self.length()]
    }

    /// Returns the scales of displacement, m, velocity, m/s, and force, N.
    pub fn scales(&self) -> [f64; 3] {
        let omega = TAU * DRIVE_HZ;
        let vibration = self.problem.sliding_m_per_s / VELOCITY_RATIO;
        [vibration / omega, vibration, self.problem.coulomb_n]
    }
}

/// Longest step that a peer may take between reversals: two reversals in one step would be missed.
pub const LONGEST_STEP: f64 = TAU / 6.0;

/// Longest first step after a reversal: a step from zero slip to zero slip would hide the
/// reversals.
pub const LONGEST_FIRST_STEP: f64 = TAU / 8.0;

#[cfg(test)]
mod tests {
    use contact::table_4_1::COULOMB_N;

    use super::*;

    #[test]
    fn scales_of_table_4_1() {
        // Friction is 5.1e-5 of the forcing; kappa 0.40452.
        let scaled = Case::new(Kind::Ordinary, 10).scaled;
        assert!((scaled.friction / scaled.forcing - COULOMB_N / FORCE_N).abs() < 1e-15);
        assert!((scaled.kappa - 0.404_52).abs() < 1e-5);
        assert!((scaled.forcing - (1.0 - scaled.spring)).abs() < 1e-12);
    }

    #[test]
    fn strong_coupling_is_strong() {
        let scaled = Case::new(Kind::Strong, 10).scaled;
        assert!((scaled.kappa - STRONG_KAPPA).abs() < 1e-12 && (scaled.friction - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_chirp_ends_at_its_last_frequency() {
        let case = Case::new(Kind::Chirp, 10);
        let at_end = case.scaled.start + case.scaled.rate * case.length();
        assert!((at_end - 80.0 / 60.0).abs() < 1e-14);
        // The same force in both units.
        let time = 0.3 * case.length();
        let force = case.problem.waveform.value(time / (TAU * DRIVE_HZ)) / FORCE_N;
        let phase = time * (case.scaled.start + 0.5 * case.scaled.rate * time);
        assert!((force - phase.cos()).abs() < 1e-12);
    }
}
