//! The record of a run: the states that traces and figures show, and the distance between two such
//! records.
//!
//! The **distance** of two records is the maximum, over the moments common to both, of
//!
//! ```text
//! |F - F'| / Fc        Fc of the moment
//! |x - x'| / max |x|   max of the record
//! |v - v'| / max |v|
//! ```
//!
//! If a run has more moments than the record can hold, every fifth is stored, or every 25th and so
//! on. Five has no factor in common with the usual numbers of steps per period, so all phases of a
//! period are covered.

use super::problem::Problem;
use super::state::State;

/// Largest number of stored moments: 8 MB.
const CAPACITY: usize = 1 << 18;
/// Factor by which a full record is thinned.
const THINNING_FACTOR: u64 = 5;
/// Time difference below which two moments count as the same, as a fraction of the excitation
/// period.
const SAME_MOMENT_PERIODS: f64 = 1e-9;

/// States of a run in order of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    moments: Vec<State>,
    /// Number of moments per stored moment.
    spacing: u64,
    seen: u64,
    capacity: usize,
}

impl Default for Record {
    fn default() -> Self {
        Record::with_capacity(CAPACITY)
    }
}

impl Record {
    fn with_capacity(capacity: usize) -> Self {
        Record { moments: Vec::new(), spacing: 1, seen: 0, capacity }
    }

    /// Adds the state at the end of a step.
    pub fn add(&mut self, state: &State) {
        self.seen += 1;
        if !self.seen.is_multiple_of(self.spacing) {
            return;
        }
        if self.moments.len() == self.capacity {
            self.spacing *= THINNING_FACTOR;
            let mut number = 0;
            self.moments.retain(|_| {
                number += 1;
                number % THINNING_FACTOR == 0
            });
            if !self.seen.is_multiple_of(self.spacing) {
                return;
            }
        }
        self.moments.push(*state);
    }

    /// Returns the stored states.
    pub fn moments(&self) -> &[State] {
        &self.moments
    }

    /// Returns the distance of two records of a problem. Infinite if they have no moment in common,
    /// or if one contains a NaN.
    pub fn distance(&self, other: &Record, problem: &Problem) -> f64 {
        let largest = |of: &dyn Fn(&State) -> f64| self.moments.iter().map(|state| of(state).abs()).fold(0.0, f64::max);
        let (largest_x_m, largest_v_m_per_s) = (largest(&|state| state.x_m), largest(&|state| state.v_m_per_s));
        let same_s = SAME_MOMENT_PERIODS / problem.waveform.frequency_hz();
        let mut loads = problem.load_steps.iter().peekable();
        let mut coulomb_n = problem.coulomb_n;
        let mut others = other.moments.iter().peekable();
        let mut farthest: Option<f64> = None;
        for state in &self.moments {
            while others.next_if(|other| other.time_s < state.time_s - same_s).is_some() {}
            let Some(other) = others.next_if(|other| other.time_s <= state.time_s + same_s) else { continue };
            // At the moment of a load step itself, friction still belongs to the load before.
            while let Some(&(_, force_n)) = loads.next_if(|(at_s, _)| *at_s < state.time_s - same_s) {
                coulomb_n = force_n;
            }
            let off = part(state.force_n - other.force_n, coulomb_n)
                .max(part(state.x_m - other.x_m, largest_x_m))
                .max(part(state.v_m_per_s - other.v_m_per_s, largest_v_m_per_s));
            farthest = Some(farthest.map_or(off, |farthest| farthest.max(off)));
        }
        farthest.unwrap_or(f64::INFINITY)
    }
}

/// Returns a difference as a fraction of a reference; infinite for NaN.
fn part(difference: f64, size: f64) -> f64 {
    match difference.abs() {
        0.0 => 0.0,
        difference if (difference / size).is_nan() => f64::INFINITY,
        difference => difference / size,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table_4_1::table_4_1;

    fn record(moments: usize, of: impl Fn(f64) -> State) -> Record {
        let mut record = Record::default();
        (1..=moments).for_each(|step| record.add(&of(step as f64 / (12.0 * 60e3))));
        record
    }

    fn state(time_s: f64) -> State {
        let phase = std::f64::consts::TAU * 60e3 * time_s;
        State { time_s, x_m: 1e-7 * phase.sin(), v_m_per_s: 0.04 * phase.cos(), force_n: 0.02 * phase.sin() }
    }

    #[test]
    fn distance_uses_common_moments_only() {
        let problem = table_4_1(0.5, 10.0);
        let one = record(120, state);
        assert_eq!(one.distance(&one, &problem), 0.0);
        // Differs only at the odd moments, which the coarse record does not contain.
        let odd = |time_s: f64| (12.0 * 60e3 * time_s).round() as u64 % 2 == 1;
        let off = record(120, |time_s| {
            let state = state(time_s);
            State { force_n: state.force_n + if odd(time_s) { 0.1 * problem.coulomb_n } else { 0.0 }, ..state }
        });
        let mut coarse = Record::default();
        one.moments().iter().skip(1).step_by(2).for_each(|state| coarse.add(state));
        assert!((one.distance(&off, &problem) - 0.1).abs() < 1e-12);
        assert_eq!((coarse.distance(&off, &problem), off.distance(&coarse, &problem)), (0.0, 0.0));
        assert_eq!(one.distance(&Record::default(), &problem), f64::INFINITY);
    }

    #[test]
    fn displacement_velocity_and_friction_each_count() {
        let problem = table_4_1(0.5, 10.0);
        let one = record(120, state);
        for moved in [
            |state: State| State { x_m: state.x_m + 1e-9, ..state },
            |state: State| State { v_m_per_s: state.v_m_per_s - 4e-4, ..state },
            |state: State| State { force_n: state.force_n * f64::NAN, ..state },
        ] {
            let distance = one.distance(&record(120, |time_s| moved(state(time_s))), &problem);
            assert!((distance - 0.01).abs() < 1e-6 || distance == f64::INFINITY, "{distance}");
        }
    }

    #[test]
    fn friction_is_relative_to_the_load_of_its_moment() {
        let mut problem = table_4_1(0.5, 10.0);
        problem.load_steps = vec![(5.0 / 60e3, 0.1 * problem.coulomb_n)];
        let off = 1e-3 * problem.coulomb_n;
        let moved_at = |period: f64| {
            record(120, |time_s| {
                let state = state(time_s);
                let here = (time_s * 60e3 - period).abs() < 1e-6;
                State { force_n: state.force_n + if here { off } else { 0.0 }, ..state }
            })
        };
        for (period, expected) in [(2.0, 1e-3), (5.0, 1e-3), (8.0, 1e-2)] {
            let distance = record(120, state).distance(&moved_at(period), &problem);
            assert!((distance - expected).abs() < 1e-9, "{period}: {distance}");
        }
    }

    #[test]
    fn a_long_record_has_every_phase_of_a_period() {
        let mut record = Record::with_capacity(100);
        (1..=12_000u32).for_each(|step| record.add(&state(f64::from(step) / (12.0 * 60e3))));
        let steps: Vec<u64> = record.moments().iter().map(|state| (12.0 * 60e3 * state.time_s).round() as u64).collect();
        assert!(steps.len() > 15 && steps.len() <= 100, "{}", steps.len());
        for pair in steps.windows(2) {
            assert_eq!(pair[1] - pair[0], steps[0]);
        }
        assert!((0..12).all(|phase| steps.iter().any(|step| step % 12 == phase)), "{steps:?}");
        assert!(12_000 - steps[steps.len() - 1] < 2 * steps[0]);
    }
}
