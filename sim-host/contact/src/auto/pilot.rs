//! The pilot of a run: its first periods, on which settings are compared before one of them does the whole record.
//!
//! What a setting is off by in a periodic problem is made at every reversal anew, so a few periods of the excitation, and some of the
//! oscillator's own, have it. What it does to the oscillator adds up, as a random walk at the least, until the damper has forgotten it:
//!
//! ```text
//! e(record) = e(pilot) sqrt(min(T, 1 / (zeta wn)) / T(pilot))
//! ```
//!
//! So it is where the bristles have forgotten their past within the pilot. Bristles longer than the vibration wander for many periods, and what
//! is off with them, and with the motion under them, grows by powers of the time: by the third, to be sure. Where the pilot cannot be good enough
//! for that, two runs of the whole record are compared.

use std::f64::consts::TAU;

use super::refine::ROUND_OFF_OF_SUMS;
use crate::method::Method;
use crate::problem::{Law, Motion, Problem};

/// Fewest periods of a pilot, and the part of the record that it is in a longer one. A shorter pilot costs as much as it saves: two runs of so short
/// a record are cheaper than the finer setting that its error, grown by the third power of the time, would ask for.
const PERIODS: f64 = 15.0;
const PART: f64 = 1.0 / 16.0;
/// Longest pilot, in periods.
const LONGEST: f64 = 256.0;
/// Fewest periods of the oscillator itself.
const OWN_PERIODS: f64 = 2.0;
/// A pilot is worth its while where the record is this many times longer.
const WORTH: f64 = 4.0;
/// Lengths of the bristles that the contact slips over until they have forgotten.
const FORGETS: f64 = 3.0;
/// Largest error of a pilot that is to be believed: a coarser run may yet lose its way.
const MOST: f64 = 1e-5;
/// By this the record's error is smaller than the pilot's times its growth in nearly all contacts: an estimate within this part is enough.
const MARGIN: f64 = 0.1;
/// Growth of the error from the first half of the pilot to the second up to which it does.
const STEADY: f64 = 3.0;

/// The first periods of a problem.
#[derive(Clone, Debug)]
pub struct Pilot {
    /// As a problem, with the mean over all of them.
    pub problem: Problem,
    /// How much larger the error of the record may be.
    pub growth: f64,
}

impl Pilot {
    /// The pilot of a problem for a method; none where its first periods do not stand for the others.
    pub fn of(method: Method, problem: &Problem) -> Option<Self> {
        if !problem.waveform.is_periodic() || !problem.load_steps.is_empty() || problem.law == Law::Coulomb {
            return None;
        }
        // A mass that its friction holds at times lets go of what it was off by, and more: that grows with every period, and by no power of the time.
        if problem.holds() {
            return None;
        }
        let hz = problem.waveform.frequency_hz();
        let own = problem.motion.natural_hz().map_or(0.0, |natural| OWN_PERIODS * hz / natural);
        let most = (problem.duration_s * hz / WORTH).floor();
        let periods = (PART * problem.duration_s * hz).clamp(PERIODS, LONGEST).max(own).ceil().min(most);
        // A mass that has not come back may do so with reversals that it has not had, and what friction pumps is another motion a few periods later.
        if periods < PERIODS.max(own) {
            return None;
        }
        // Beside its resonance the mass beats; of what adds up in a beat its first part has nothing.
        let beat_hz = problem.motion.natural_hz().map_or(f64::INFINITY, |natural| (natural - hz).abs());
        if beat_hz * periods < hz {
            return None;
        }
        // Where the record's window begins or ends within a period, so does that of the pilot: half a period has an error that two do not.
        let (from, to) = (problem.window_s.0 * hz, problem.window_s.1 * hz);
        let duration_s = (periods + part(to)) / hz;
        // What is off at the start counts for nothing where the record's window begins later.
        let settled = if from > periods { (0.5 * periods).floor() } else { 0.0 };
        let first = Problem { window_s: ((settled + part(from)) / hz, duration_s), duration_s, ..problem.clone() };
        let slipped_m = 4.0 * problem.vibration_m_per_s() / (TAU * hz) * periods + problem.sliding_m_per_s.abs() * duration_s;
        let kt = problem.law.stiffness_n_per_m();
        let forgets = kt.is_none_or(|kt| slipped_m.min(1e6) * kt > FORGETS * problem.coulomb_n);
        let longer = problem.duration_s / duration_s;
        let growth = match problem.motion {
            // What is off with bristles that remember, and with the motion under them, grows by powers of the time.
            _ if !forgets => longer.powi(3),
            // The same truncation in every period is no random walk.
            _ if method == Method::Taylor => longer.powi(2),
            Motion::Kinematic => 1.0,
            Motion::Sdof { mass_kg, damping_n_s_per_m, .. } => {
                let damped_s = 2.0 * mass_kg / damping_n_s_per_m;
                (damped_s.min(problem.duration_s) / duration_s).sqrt().max(1.0)
            }
        };
        Some(Pilot { problem: first, growth })
    }

    /// The error that is to be reached on it for a tolerance of the record.
    pub fn goal(&self, tolerance: f64) -> f64 {
        (MARGIN * tolerance / self.growth).clamp(2.0 * ROUND_OFF_OF_SUMS, MOST)
    }

    /// Whether an error, which grows so much from the pilot's first half to its second, is known of the record, too.
    pub fn stands_for_the_record(&self, error: f64, growth: f64, tolerance: f64) -> bool {
        growth <= STEADY && error <= self.goal(tolerance) && MARGIN * tolerance >= ROUND_OFF_OF_SUMS * self.growth
    }
}

/// The part of a period that a number of periods ends with; none where that is round-off.
fn part(periods: f64) -> f64 {
    let part = periods - periods.floor();
    if part.min(1.0 - part) < 1e-6 { 0.0 } else { part }
}
