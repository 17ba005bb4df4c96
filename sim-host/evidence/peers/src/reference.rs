//! The reference solution: a Taylor series of high order with located reversals.
//!
//! Every coefficient follows from those before it (products by one Cauchy sum; Barrio 2005), so
//! only truncation and rounding limit the series. It was written for this comparison alone and is
//! not one of the peers. The series of `contact`, in other units and steps, must agree to
//! [`AGREEMENT`]; otherwise there is no reference.

mod series;

use std::f64::consts::TAU;

use anyhow::ensure;
use contact::{Problem, taylor};

use self::series::Series;
use crate::case::Case;
use crate::peer::Outcome;
use crate::scaled::Clock;

/// Number of steps a period, not counting those that end at reversals.
const STEPS: u32 = 64;
/// Fraction of the distance to a Stribeck peak, or of its width, by which the slip may change in a
/// step.
const SLIP_CHANGE_REL: f64 = 0.2;
/// Shortest step near a Stribeck peak, scaled.
const MIN_STEP: f64 = 1e-4;
/// Largest difference between the two methods, in the mean and at the end. `contact` counts the
/// phase of a chirp in turns from the beginning, and its rounding sets this limit; all other cases
/// agree much better.
const AGREEMENT: f64 = 2e-11;
/// Order of the series of `contact`.
const SECOND_ORDER: u32 = 32;
/// Number of steps a period of the series of `contact`.
const SECOND_STEPS: u32 = 24;

/// The reference of a case.
pub struct Reference {
    mean: f64,
    end: [f64; 3],
    /// Difference of the second method: in the mean, and at the end.
    pub apart: (f64, f64),
    /// Reversals of the slip in the whole run.
    pub reversals: u32,
}

impl Reference {
    /// Solves the case twice and compares.
    ///
    /// # Errors
    /// If the two do not agree.
    pub fn new(case: &Case) -> anyhow::Result<Self> {
        let (Outcome { mean, end, .. }, reversals) = solve(case);
        let mut reference = Reference { mean, end, apart: (0.0, 0.0), reversals };
        reference.apart = reference.errors(&second(case)?);
        let (mean, end) = reference.apart;
        ensure!(
            mean < AGREEMENT && end < AGREEMENT,
            "no reference: two methods differ by {mean:.1e} in the mean, {end:.1e} at the end"
        );
        Ok(reference)
    }

    /// Returns the mean friction ratio.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Returns the absolute error of an outcome's mean, and the error of its end: the largest of
    /// the errors of displacement and velocity over the size of the motion, and of friction over
    /// Fc.
    pub fn errors(&self, outcome: &Outcome) -> (f64, f64) {
        let [x, v, _] = self.end;
        let motion = x.hypot(v).max(1.0);
        let over = [motion, motion, 1.0];
        let end = (0..3)
            .map(|i| (outcome.end[i] - self.end[i]).abs() / over[i])
            .fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a });
        ((outcome.mean - self.mean).abs(), end)
    }
}

/// Solves the case by the series of `contact`.
fn second(case: &Case) -> anyhow::Result<Outcome> {
    let problem: &Problem = &case.problem;
    let tally = taylor::run(problem, SECOND_STEPS, SECOND_ORDER, &mut |_| ())?;
    let [length, velocity, force] = case.scales();
    let last = tally.last;
    let mean = contact::tally::Ratios::of(problem, &tally).friction;
    Ok(Outcome { mean, end: [last.x_m / length, last.v_m_per_s / velocity, last.force_n / force], wall_ns: 0.0 })
}

/// Solves the case by [`Series`], and returns the number of reversals too.
fn solve(case: &Case) -> (Outcome, u32) {
    let scaled = &case.scaled;
    let mut clock = Clock::new(scaled);
    let (mut y, mut sign, mut reversals) = ([0.0; 4], 1.0, 0);
    let mut states = [y; 2];
    for (mark, state) in case.marks().into_iter().zip(&mut states) {
        loop {
            let left = clock.until(mark);
            if left <= 0.0 {
                break;
            }
            let series = Series::new(scaled, sign, &clock, &y);
            let mut step = TAU / f64::from(STEPS);
            if scaled.excess != 0.0 {
                let slip = scaled.slip(&y).abs();
                // The acceleration of the motion is of order one.
                step = step.min((SLIP_CHANGE_REL * slip.max(scaled.stribeck)).max(MIN_STEP));
            }
            let ends = step >= left;
            let length = step.min(left);
            match series.reversal(scaled.sliding, sign, length) {
                Some(at) => {
                    y = series.at(at);
                    (y[1], sign) = (-scaled.sliding, -sign);
                    reversals += 1;
                    clock.advance(at);
                }
                None => {
                    y = series.at(length);
                    clock.advance(length);
                    if ends {
                        break;
                    }
                }
            }
        }
        *state = y;
    }
    (Outcome::new(scaled, sign, &states[0], &states[1], 0.0), reversals)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Kind;

    #[test]
    fn two_methods_agree() {
        for kind in Kind::ALL {
            let reference = Reference::new(&Case::new(kind, 100)).unwrap();
            println!("{kind:?}: {:?}, {} reversals", reference.apart, reference.reversals);
            assert!(reference.apart.0 < 3e-14 && reference.apart.1 < 3e-13, "{kind:?}: {:?}", reference.apart);
        }
    }

    #[test]
    fn errors_are_those_of_the_outcome() {
        let case = Case::new(Kind::Ordinary, 4);
        let reference = Reference::new(&case).unwrap();
        let (mut outcome, _) = solve(&case);
        assert_eq!(reference.errors(&outcome), (0.0, 0.0));
        outcome.mean += 1e-3;
        outcome.end[2] -= 1e-2;
        let (mean, end) = reference.errors(&outcome);
        assert!((mean - 1e-3).abs() < 1e-15 && (end - 1e-2).abs() < 1e-15);
        outcome.end[0] = f64::NAN;
        assert!(reference.errors(&outcome).1.is_nan());
    }
}
