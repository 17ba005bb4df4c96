//! Runs on ever higher rungs of a [`Ladder`] until one meets the tolerance, with an estimate of the
//! error of each.
//!
//! The **distance** of two runs is the root mean square of the difference of their mean friction,
//! over Fc, on the spans between the [`Marks`](crate::tally::Marks) of the window. It is never less
//! than the difference of the means over the whole window, and not small by chance. With the
//! distances d1 and d2 of three successive runs a, b, c
//!
//! ```text
//! q    = d2 / d1                   observed contraction; expected is 1/4 per rung or less
//! e(c) = d2 q' / (1 - q')          geometric series (Richardson), with q' at least the expected
//!                                  one, and d2 at least q' d1
//! e(c) = max(d1, d2)               if the runs do not contract: another run is needed
//! e(i) = d(i, c) + e(c)            for any coarser run
//! ```
//!
//! If the tolerance limits the whole record, the distance is at least that of the
//! [records](crate::record).
//!
//! Two runs, two rungs apart, give only their distance d. This is taken as the error of the finer
//! run, with a larger margin to the tolerance.

use super::ladder::{CONTRACTION, Ladder, Setting};
use crate::SolveError;
use crate::problem::Problem;
use crate::record::Record;
use crate::tally::Tally;

/// Round-off error of a mean over many steps.
pub const ROUND_OFF_OF_SUMS: f64 = 1e-13;
/// Largest ratio of successive distances, per rung, at which runs count as contracting.
const CONTRACTING_RATIO: f64 = 0.5;
/// Fraction of the tolerance within which an estimate from three runs suffices.
const MARGIN_OF_THREE: f64 = 0.6;
/// Fraction of the tolerance within which an estimate from two runs suffices.
const MARGIN_OF_TWO: f64 = 0.5;
/// Distance below which runs that no longer contract differ by round-off, in a stiff contact or a
/// long run.
const ROUND_OFF_DISTANCE: f64 = 1e-9;
/// Largest number of rungs to go up at once.
const MAX_STRIDE_RUNGS: f64 = 3.0;

/// Run on a rung.
#[derive(Clone, Debug)]
pub struct Rung {
    /// Number of the rung.
    pub rung: usize,
    /// Steps and order of the rung.
    pub setting: Setting,
    /// Sums of the run.
    pub tally: Tally,
    /// Record of the run; `None` unless the tolerance limits the record.
    pub record: Option<Record>,
}

/// Result of a run: its sums, and its record if the tolerance limits the record.
pub type Ran = (Tally, Option<Record>);

/// Successive runs of one problem.
#[derive(Clone, Debug)]
pub struct Refinement<'a> {
    problem: &'a Problem,
    /// Runs from coarse to fine.
    runs: Vec<Rung>,
    /// `true` if two runs are enough.
    two_suffice: bool,
    /// Safety factor on the errors, for contacts in which they fall unevenly.
    safety_factor: f64,
}

/// Run that was chosen.
#[derive(Clone, Debug)]
pub struct Found {
    /// Steps and order of the coarsest run that meets the tolerance, or of the finest run if none
    /// does.
    pub setting: Setting,
    /// Time integrals over the window of the run; `None` if only a part of the problem was run.
    pub tally: Option<Tally>,
    /// Estimated error of the mean friction.
    pub error: f64,
    /// Estimated error of the record; `None` unless the tolerance limits the record.
    pub record_error: Option<f64>,
    /// Error of the second half of the window over that of the first.
    pub growth: f64,
}

impl Found {
    /// Returns the error of the quantity that the tolerance limits.
    pub fn decisive(&self) -> f64 {
        self.record_error.unwrap_or(self.error)
    }
}

/// Function that returns the distance of two runs.
type Apart<'a> = &'a dyn Fn(&Rung, &Rung) -> f64;

impl<'a> Refinement<'a> {
    /// Prepares three runs or more, on successive rungs, with `safety_factor` on their
    /// errors.
    pub fn from_three_runs(problem: &'a Problem, safety_factor: f64) -> Self {
        Refinement { problem, runs: Vec::new(), two_suffice: false, safety_factor }
    }

    /// Prepares two runs, and more if they do not agree.
    pub fn from_two_runs(problem: &'a Problem, safety_factor: f64) -> Self {
        Refinement { problem, runs: Vec::new(), two_suffice: true, safety_factor }
    }

    /// Returns the distance of two runs in the quantity that the tolerance limits.
    fn apart(&self, one: &Rung, other: &Rung) -> f64 {
        let means = distance(&one.tally, &other.tally).0;
        match (&one.record, &other.record) {
            (Some(a), Some(b)) => means.max(a.distance(b, self.problem)),
            _ => means,
        }
    }

    /// Climbs until a run meets the tolerance, from rung `start`, above any existing runs.
    pub fn climb(
        &mut self,
        ladder: &Ladder,
        start: usize,
        tolerance: f64,
        run: &mut dyn FnMut(Setting) -> Result<Ran, SolveError>,
    ) -> Result<Found, SolveError> {
        let mut next = start;
        while let Some(setting) = ladder.setting(next) {
            match run(setting) {
                Ok((tally, record)) => self.runs.push(Rung { rung: next, setting, tally, record }),
                // A step that is too coarse may diverge although a finer one does not.
                Err(SolveError::Diverged { .. }) if ladder.setting(next + 2).is_some() => {
                    self.runs.clear();
                    next += 2;
                    continue;
                }
                Err(error) => return Err(error),
            }
            let errors = self.errors(&|one, other| self.apart(one, other));
            let Some(&least) = errors.last().filter(|_| self.runs.len() > 2 || self.two_suffice) else {
                next += if self.two_suffice { ladder.apart() } else { 1 };
                continue;
            };
            let enough = self.margin() * tolerance;
            if errors.iter().any(|&error| error <= enough) || self.is_round_off() {
                break;
            }
            let stride = ladder.stride();
            let seen = self.seen(&|one, other| self.apart(one, other)).unwrap_or(stride).clamp(stride, CONTRACTING_RATIO);
            let rungs = (least / enough).ln() / (1.0 / seen).ln();
            // Two infinite distances give NaN, which counts as one rung.
            next += (rungs.ceil().min(MAX_STRIDE_RUNGS) as usize).max(1);
        }
        self.coarsest(self.margin() * tolerance).ok_or_else(|| SolveError::Refused {
            reason: "every affordable step is unstable".into(),
            advice: "use a shorter run, or fewer Dahl lengths per vibration amplitude".into(),
        })
    }

    fn margin(&self) -> f64 {
        if self.runs.len() > 2 { MARGIN_OF_THREE } else { MARGIN_OF_TWO }
    }

    /// Returns `true` if the last runs differ by round-off; finer ones would have more of it.
    fn is_round_off(&self) -> bool {
        let [.., a, b, c, d] = self.runs.as_slice() else { return false };
        let [first, .., last] = [(a, b), (b, c), (c, d)].map(|(one, other)| self.apart(one, other));
        first < ROUND_OFF_DISTANCE && last > CONTRACTING_RATIO * first
    }

    /// Returns the coarsest run whose error is within the tolerance, or the finest run.
    fn coarsest(&self, tolerance: f64) -> Option<Found> {
        let errors = self.errors(&|one, other| self.apart(one, other));
        let index = errors.iter().position(|&error| error <= tolerance).unwrap_or(self.runs.len().checked_sub(1)?);
        let (rung, finest) = (&self.runs[index], self.runs.last()?);
        let other = if index + 1 < self.runs.len() { finest } else { self.runs.get(index.wrapping_sub(1)).unwrap_or(rung) };
        let growth = distance(&rung.tally, &other.tally).1;
        let error = |errors: &[f64]| errors.get(index).copied().unwrap_or(f64::INFINITY);
        let found = Found { setting: rung.setting, tally: Some(rung.tally), error: error(&errors), record_error: None, growth };
        if rung.record.is_none() {
            return Some(found);
        }
        let of_means = self.errors(&|one, other| distance(&one.tally, &other.tally).0);
        Some(Found { error: error(&of_means), record_error: Some(error(&errors)), ..found })
    }

    /// Returns the observed ratio of successive distances, per rung.
    fn seen(&self, apart: Apart) -> Option<f64> {
        let [.., a, b, c] = self.runs.as_slice() else { return None };
        let (d1, d2) = (apart(a, b), apart(b, c));
        Some((d2.max(ROUND_OFF_OF_SUMS) / d1.max(ROUND_OFF_OF_SUMS)).powf(1.0 / (b.rung - a.rung) as f64))
    }

    /// Returns that ratio if the runs contract, limited to the expected contraction.
    fn contraction(&self, apart: Apart) -> Option<f64> {
        self.seen(apart).filter(|&seen| seen <= CONTRACTING_RATIO).map(|seen| seen.max(CONTRACTION))
    }

    /// Returns the estimated error of each run; empty for a single run.
    fn errors(&self, apart: Apart) -> Vec<f64> {
        let least = self.runs.last().map_or(ROUND_OFF_OF_SUMS, |finest| round_off(&finest.tally));
        let last = match self.runs.as_slice() {
            [] | [_] => return Vec::new(),
            [a, b] => apart(a, b),
            [.., a, b, c] => {
                let (d1, d2) = (apart(a, b), apart(b, c));
                match self.contraction(apart) {
                    Some(q) => {
                        let expected = q.powi((b.rung - a.rung) as i32);
                        let left = q.powi((c.rung - b.rung) as i32);
                        d2.max(expected * d1) * left / (1.0 - left)
                    }
                    None => d1.max(d2),
                }
            }
        };
        let Some((finest, coarser)) = self.runs.split_last() else { return Vec::new() };
        let of = |rung: &Rung| (apart(rung, finest) + last).max(least);
        coarser.iter().map(of).chain([last.max(least)]).map(|error| self.safety_factor * error).collect()
    }
}

/// Returns the round-off of a mean over the steps of a run: over Fc, or relative to the mean if
/// bristle damping raises it above Fc.
fn round_off(tally: &Tally) -> f64 {
    let mean = (tally.totals.friction_n_s / (tally.coulomb_n * tally.time_s)).abs();
    ROUND_OFF_OF_SUMS.max(f64::EPSILON * (tally.steps as f64).sqrt()) * mean.max(1.0)
}

/// Returns the distance of the means of two runs of a problem, over Fc, and its ratio between the
/// second and the first half of the window.
pub fn distance(one: &Tally, other: &Tally) -> (f64, f64) {
    let whole = (one.totals.friction_n_s - other.totals.friction_n_s).abs() / (one.coulomb_n * one.time_s);
    let (a, b) = (one.marks.get(), other.marks.get());
    if a.len() != b.len() || a.len() < 4 {
        return (whole, 1.0);
    }
    // The last span is from the last mark to the end of the window.
    let end = |tally: &Tally, first: f64| (tally.first.time_s + tally.time_s, first + tally.totals.friction_n_s);
    let (a_end, b_end) = (end(one, a[0].1), end(other, b[0].1));
    let spans = a.iter().zip(b).zip(a.iter().skip(1).chain([&a_end]).zip(b.iter().skip(1).chain([&b_end])));
    let (mut halves, mut times) = ([0.0; 2], [0.0; 2]);
    for ((from, other_from), (to, other_to)) in spans {
        let time_s = to.0 - from.0;
        if time_s <= 0.0 {
            continue;
        }
        let off = ((to.1 - from.1) - (other_to.1 - other_from.1)) / (one.coulomb_n * time_s);
        let half = usize::from(from.0 + 0.5 * time_s - one.first.time_s > 0.5 * one.time_s);
        halves[half] += off * off * time_s;
        times[half] += time_s;
    }
    let rms = ((halves[0] + halves[1]) / (times[0] + times[1])).sqrt();
    let half = |i: usize| (halves[i] / times[i]).sqrt().max(ROUND_OFF_OF_SUMS);
    (rms.max(whole), half(1) / half(0))
}
