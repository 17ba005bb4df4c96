//! Runs on ever higher rungs of a [`Ladder`] until one is known to meet the tolerance, and how large the error of each is.
//!
//! The **distance** of two runs is the root mean square of what their mean friction differs by, over Fc, on the spans between the
//! [`Marks`](crate::tally::Marks) of the window: never less than the difference of the means over the whole window, and not small by chance.
//! With the distances d1 and d2 of three successive runs a, b, c
//!
//! ```text
//! q    = d2 / d1                   contraction that is seen; expected is 1/4 a rung or less
//! e(c) = d2 q' / (1 - q')          geometric series (Richardson), with q' no smaller than expected, and d2 no smaller than q' d1
//! e(c) = max(d1, d2)               where the runs do not contract: one more is needed
//! e(i) = d(i, c) + e(c)            of any coarser run
//! ```
//!
//! Where the tolerance is of the whole record, the distance is no less than that of the [records](crate::record).
//!
//! Of two runs, two rungs apart, all that is known is their distance d: the finer is taken to be off by as much, and has to be better than
//! the tolerance by more.

use super::ladder::{CONTRACTION, Ladder, Setting};
use crate::SolveError;
use crate::problem::Problem;
use crate::record::Record;
use crate::tally::Tally;

/// Error of a mean over many steps.
pub const ROUND_OFF_OF_SUMS: f64 = 1e-13;
/// Runs contract if the distance falls at least by this on a rung.
const CONTRACTS: f64 = 0.5;
/// An estimate within this part of the tolerance is enough: by three runs, and by two.
const MARGIN: f64 = 0.6;
const MARGIN_OF_TWO: f64 = 0.5;
/// Distances below this that do not fall any more are round-off, of a stiff contact or a long run.
const SMALL: f64 = 1e-9;
/// Most rungs at once.
const LONGEST_STRIDE: f64 = 3.0;

/// A run on a rung.
#[derive(Clone, Debug)]
pub struct Rung {
    /// Number of the rung.
    pub rung: usize,
    /// Its steps and order.
    pub setting: Setting,
    /// What the run added up.
    pub tally: Tally,
    /// What it has shown, where the tolerance is of that.
    pub record: Option<Record>,
}

/// What a run has left: its sums, and its record where the tolerance is of that.
pub type Ran = (Tally, Option<Record>);

/// Successive runs of one problem.
#[derive(Clone, Debug)]
pub struct Runs<'a> {
    problem: &'a Problem,
    /// From coarse to fine.
    runs: Vec<Rung>,
    /// Whether two runs are enough.
    of_two: bool,
    /// What the errors are multiplied by where they fall unevenly.
    doubt: f64,
}

/// The run that was chosen.
#[derive(Clone, Debug)]
pub struct Found {
    /// Steps and order of the coarsest run that meets the tolerance; of the finest where none does.
    pub setting: Setting,
    /// What it added up; none where only a part of the problem was run.
    pub tally: Option<Tally>,
    /// Its estimated error.
    pub error: f64,
    /// The same of its record, where the tolerance is of that.
    pub record_error: Option<f64>,
    /// How much larger the error of the second half is than that of the first.
    pub growth: f64,
}

impl Found {
    /// The error of what the tolerance is of.
    pub fn decisive(&self) -> f64 {
        self.record_error.unwrap_or(self.error)
    }
}

/// How far two runs are apart.
type Apart<'a> = &'a dyn Fn(&Rung, &Rung) -> f64;

impl<'a> Runs<'a> {
    /// Three runs or more, on successive rungs; their errors may be larger by a factor than they appear.
    pub fn of_three(problem: &'a Problem, doubt: f64) -> Self {
        Runs { problem, runs: Vec::new(), of_two: false, doubt }
    }

    /// Two runs, and more where they do not agree.
    pub fn of_two(problem: &'a Problem, doubt: f64) -> Self {
        Runs { problem, runs: Vec::new(), of_two: true, doubt }
    }

    /// How far two runs are apart in what the tolerance is of.
    fn apart(&self, one: &Rung, other: &Rung) -> f64 {
        let means = distance(&one.tally, &other.tally).0;
        match (&one.record, &other.record) {
            (Some(a), Some(b)) => means.max(a.distance(b, self.problem)),
            _ => means,
        }
    }

    /// Climbs until a run has the tolerance, from a rung on, or above those that there are.
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
                // A step that is too coarse may diverge where a finer one does not.
                Err(SolveError::Diverged { .. }) if ladder.setting(next + 2).is_some() => {
                    self.runs.clear();
                    next += 2;
                    continue;
                }
                Err(error) => return Err(error),
            }
            let errors = self.errors(&|one, other| self.apart(one, other));
            let Some(&least) = errors.last().filter(|_| self.runs.len() > 2 || self.of_two) else {
                next += if self.of_two { ladder.apart() } else { 1 };
                continue;
            };
            let enough = self.margin() * tolerance;
            if errors.iter().any(|&error| error <= enough) || self.is_round_off() {
                break;
            }
            let stride = ladder.stride();
            let seen = self.seen(&|one, other| self.apart(one, other)).unwrap_or(stride).clamp(stride, CONTRACTS);
            let rungs = (least / enough).ln() / (1.0 / seen).ln();
            // Of two distances that are infinite nothing is seen, and that is no number.
            next += (rungs.ceil().min(LONGEST_STRIDE) as usize).max(1);
        }
        self.coarsest(self.margin() * tolerance).ok_or_else(|| SolveError::Refused {
            reason: "no step that can be afforded is stable".into(),
            advice: "give a shorter run, or fewer Dahl lengths in a vibration amplitude".into(),
        })
    }

    fn margin(&self) -> f64 {
        if self.runs.len() > 2 { MARGIN } else { MARGIN_OF_TWO }
    }

    /// Whether the last runs differ by round-off: finer ones have more of it.
    fn is_round_off(&self) -> bool {
        let [.., a, b, c, d] = self.runs.as_slice() else { return false };
        let [first, .., last] = [(a, b), (b, c), (c, d)].map(|(one, other)| self.apart(one, other));
        first < SMALL && last > CONTRACTS * first
    }

    /// The coarsest run whose error is within the tolerance, or the finest run.
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

    /// The part of the distance that a rung leaves.
    fn seen(&self, apart: Apart) -> Option<f64> {
        let [.., a, b, c] = self.runs.as_slice() else { return None };
        let (d1, d2) = (apart(a, b), apart(b, c));
        Some((d2.max(ROUND_OFF_OF_SUMS) / d1.max(ROUND_OFF_OF_SUMS)).powf(1.0 / (b.rung - a.rung) as f64))
    }

    /// The same where it is to be believed: the runs contract, and no faster than expected.
    fn contraction(&self, apart: Apart) -> Option<f64> {
        self.seen(apart).filter(|&seen| seen <= CONTRACTS).map(|seen| seen.max(CONTRACTION))
    }

    /// The estimated error of each run; nothing is known of one run alone.
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
        coarser.iter().map(of).chain([last.max(least)]).map(|error| self.doubt * error).collect()
    }
}

/// What adding up so many steps leaves of a mean: of Fc, and of the mean itself where bristle damping takes it beyond.
fn round_off(tally: &Tally) -> f64 {
    let mean = (tally.totals.friction_n_s / (tally.coulomb_n * tally.time_s)).abs();
    ROUND_OFF_OF_SUMS.max(f64::EPSILON * (tally.steps as f64).sqrt()) * mean.max(1.0)
}

/// How far the means of two runs of a problem are apart, of Fc; and how much more so in the second half of the window than in the first.
pub fn distance(one: &Tally, other: &Tally) -> (f64, f64) {
    let whole = (one.totals.friction_n_s - other.totals.friction_n_s).abs() / (one.coulomb_n * one.time_s);
    let (a, b) = (one.marks.get(), other.marks.get());
    if a.len() != b.len() || a.len() < 4 {
        return (whole, 1.0);
    }
    // The last span is from the last mark to the window's end.
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
