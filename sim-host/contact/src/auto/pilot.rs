//! The pilot of a run: its first periods, on which settings are compared before one of them
//! computes the whole record.
//!
//! In a periodic problem, the error of a setting arises anew at every reversal. So a few periods of
//! the excitation, and some of the oscillator, show it. The error of the oscillator accumulates, at
//! least as a random walk, until it is damped out:
//!
//! ```text
//! e(record) = e(pilot) sqrt(min(T, 1 / (zeta wn)) / T(pilot))
//! ```
//!
//! This holds if the bristles forget their past within the pilot. Bristles longer than the
//! vibration drift for many periods. Their error, and that of the motion under them, then grows as
//! a power of the time; the third power is assumed. If the pilot cannot be accurate enough for
//! that, two runs of the whole record are compared. An error that grows within the pilot may be an
//! accident of a coarse run: finer pilots are tried before.

use std::f64::consts::TAU;

use super::refine::ROUND_OFF_OF_SUMS;
use crate::method::Method;
use crate::problem::{Law, Motion, Problem};

/// Smallest number of periods of a pilot. A shorter one does not save time: it would require a
/// finer setting, because its error is assumed to grow as the third power of the time. Two runs of
/// such a short record are cheaper.
const MIN_PERIODS: f64 = 15.0;
/// Length of a pilot as a fraction of the record, for longer records.
const PILOT_FRACTION: f64 = 1.0 / 16.0;
/// Largest number of periods of a pilot.
const MAX_PERIODS: f64 = 256.0;
/// Smallest number of periods of the oscillator in a pilot.
const MIN_OWN_PERIODS: f64 = 2.0;
/// Ratio of record to pilot length above which a pilot pays off.
const MIN_RECORD_RATIO: f64 = 4.0;
/// Slip, in bristle lengths, after which the bristles have forgotten their past.
const FORGETTING_LENGTHS: f64 = 3.0;
/// Largest reliable error of a pilot; in a coarser run the motion may still diverge from the true
/// one.
const MAX_ERROR: f64 = 1e-5;
/// Fraction of the tolerance within which an estimate from a pilot suffices. In nearly all contacts
/// the record's error is below this estimate, the pilot's error times its growth.
const MARGIN: f64 = 0.1;
/// Largest growth of the error from the first half of the pilot to the second at which the pilot is
/// reliable.
const MAX_ERROR_GROWTH: f64 = 3.0;

/// First periods of a problem.
#[derive(Clone, Debug)]
pub struct Pilot {
    /// The first periods as a problem; its window gives the mean.
    pub problem: Problem,
    /// Largest expected ratio of the record's error to the pilot's.
    pub growth: f64,
}

impl Pilot {
    /// Creates the pilot of a problem for a method; `None` if its first periods do not represent
    /// the others.
    pub fn new(method: Method, problem: &Problem) -> Option<Self> {
        let is_steady = problem.load_steps.iter().all(|(at_s, _)| *at_s >= problem.duration_s);
        if !problem.waveform.is_periodic() || !is_steady || problem.law == Law::Coulomb {
            return None;
        }
        // If friction holds the mass at times, each release adds to the error, which then grows
        // faster than a power of the time.
        if problem.holds() {
            return None;
        }
        let hz = problem.waveform.frequency_hz();
        let own = problem.motion.natural_hz().map_or(0.0, |natural| MIN_OWN_PERIODS * hz / natural);
        let most = (problem.duration_s * hz / MIN_RECORD_RATIO).floor();
        let periods = (PILOT_FRACTION * problem.duration_s * hz).clamp(MIN_PERIODS, MAX_PERIODS).max(own).ceil().min(most);
        // The mass must have completed its own periods, because later ones may contain further
        // reversals. And if friction feeds energy in, the motion changes within a few periods.
        if periods < MIN_PERIODS.max(own) {
            return None;
        }
        // Near its resonance the mass beats; the first part of a beat does not represent the whole.
        let beat_hz = problem.motion.natural_hz().map_or(f64::INFINITY, |natural| (natural - hz).abs());
        if beat_hz * periods < hz {
            return None;
        }
        // If the record's window begins or ends within a period, so does the pilot's: half a period
        // has an error that two halves do not have.
        let (from, to) = (problem.window_s.0 * hz, problem.window_s.1 * hz);
        let duration_s = (periods + part(to)) / hz;
        // If the record's window begins later than the pilot ends, errors of the start do not
        // matter.
        let settled = if from > periods { (0.5 * periods).floor() } else { 0.0 };
        let first = Problem { window_s: ((settled + part(from)) / hz, duration_s), duration_s, ..problem.clone() };
        let slipped_m = 4.0 * problem.vibration_m_per_s() / (TAU * hz) * periods + problem.sliding_m_per_s.abs() * duration_s;
        let kt = problem.law.stiffness_n_per_m();
        let forgets = kt.is_none_or(|kt| slipped_m.min(1e6) * kt > FORGETTING_LENGTHS * problem.coulomb_n);
        let longer = problem.duration_s / duration_s;
        let growth = match problem.motion {
            // Errors of bristles that remember, and of the motion under them, grow as a power of
            // the time.
            _ if !forgets => longer.powi(3),
            // The truncation is the same in every period, so the error is not a random walk.
            _ if method == Method::Taylor => longer.powi(2),
            Motion::Kinematic => 1.0,
            Motion::Sdof { mass_kg, damping_n_s_per_m, .. } => {
                let damped_s = 2.0 * mass_kg / damping_n_s_per_m;
                (damped_s.min(problem.duration_s) / duration_s).sqrt().max(1.0)
            }
        };
        Some(Pilot { problem: first, growth })
    }

    /// Returns the error to be reached on the pilot for a tolerance of the record.
    pub fn goal(&self, tolerance: f64) -> f64 {
        (MARGIN * tolerance / self.growth).clamp(2.0 * ROUND_OFF_OF_SUMS, MAX_ERROR)
    }

    /// Returns `true` if an error of the pilot, with its growth from the first half to the second,
    /// is valid for the record, too.
    pub fn stands_for_the_record(&self, error: f64, growth: f64, tolerance: f64) -> bool {
        growth <= MAX_ERROR_GROWTH && error <= self.goal(tolerance) && MARGIN * tolerance >= ROUND_OFF_OF_SUMS * self.growth
    }
}

/// Returns the fraction of a period at the end of a number of periods; zero if it is round-off.
fn part(periods: f64) -> f64 {
    let part = periods - periods.floor();
    if part.min(1.0 - part) < 1e-6 { 0.0 } else { part }
}
