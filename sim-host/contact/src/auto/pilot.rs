//! The pilot of a run: its first periods, on which settings are compared before one of them does the whole record.
//!
//! What a setting is off by in a periodic problem is made at every reversal anew, so a few periods of the excitation, and some of the
//! oscillator's own, have it. What it does to the oscillator adds up, as a random walk at the least, until the damper has forgotten it:
//!
//! ```text
//! e(record) = e(pilot) sqrt(min(T, 1 / (zeta wn)) / T(pilot))
//! ```
//!
//! A contact that the mass feels, `Kt / (m w^2)` or `Fc / F0` times the periods no longer small, makes more of it; then two runs of the
//! whole record are compared.

use std::f64::consts::TAU;

use crate::problem::{Law, Motion, Problem};
use crate::waveform::Shape;

/// Fewest periods of a pilot, and part of the record that it is in a longer one.
const PERIODS: f64 = 15.0;
const PART: f64 = 1.0 / 16.0;
/// Longest pilot, in periods.
const LONGEST: f64 = 256.0;
/// Fewest periods of the oscillator itself.
const OWN_PERIODS: f64 = 2.0;
/// A pilot is worth its while where the record is this many times longer.
const WORTH: f64 = 4.0;
/// Contact spring, of `m w^2`, and friction, of the force, times the periods that it adds up in, up to which the pilot stands for the
/// record.
const WEAK: (f64, f64) = (0.01, 0.1);
/// Growth of the error from the first half of the pilot to the second up to which it does.
const STEADY: f64 = 3.0;

/// The first periods of a problem.
#[derive(Clone, Debug)]
pub struct Pilot {
    /// As a problem, with the mean over all of them.
    pub problem: Problem,
    /// How much larger the error of the record may be, where the pilot stands for it.
    pub growth: f64,
    /// Whether motion and friction are coupled weakly.
    weak: bool,
}

impl Pilot {
    /// The pilot of a problem; none where its first periods do not stand for the others.
    pub fn of(problem: &Problem) -> Option<Self> {
        let periodic = matches!(problem.waveform.shape(), Shape::Sine | Shape::Square | Shape::Sawtooth | Shape::Triangle);
        if !periodic || !problem.load_steps.is_empty() || problem.law == Law::Coulomb {
            return None;
        }
        let hz = problem.waveform.frequency_hz();
        let own = problem.motion.natural_hz().map_or(0.0, |natural| OWN_PERIODS * hz / natural);
        let periods = (PART * problem.duration_s * hz).clamp(PERIODS, LONGEST).max(own).ceil();
        let duration_s = periods / hz;
        if WORTH * duration_s > problem.duration_s {
            return None;
        }
        let kt = match problem.law {
            Law::Coulomb => 0.0,
            Law::Dahl { stiffness_n_per_m } | Law::Lugre { stiffness_n_per_m, .. } => stiffness_n_per_m,
        };
        let (weak, forgets_s) = match problem.motion {
            Motion::Kinematic => (true, 0.0),
            Motion::Sdof { mass_kg, damping_n_s_per_m, .. } => {
                let spring = kt / (mass_kg * (TAU * hz).powi(2));
                let friction = problem.coulomb_n / problem.waveform.amplitude().abs();
                let forgets_s = 2.0 * mass_kg / damping_n_s_per_m;
                (spring < WEAK.0 && friction * forgets_s.min(problem.duration_s) * hz < WEAK.1, forgets_s)
            }
        };
        let growth = if weak { (forgets_s.min(problem.duration_s) / duration_s).sqrt().max(1.0) } else { 1.0 };
        let first = Problem { window_s: (0.0, duration_s), duration_s, ..problem.clone() };
        Some(Pilot { problem: first, growth, weak })
    }

    /// Whether an error that grows so much from the pilot's first half to its second is known of the record, too.
    pub fn stands_for_the_record(&self, growth: f64) -> bool {
        self.weak && growth <= STEADY
    }
}
