//! Hard cases, each with what the thesis's method does, what the method chosen for it does, and what must hold.
//!
//! The same list is run by the command and by the test below: a check that fails is a failing test.

pub mod directions;
mod limit;
mod load;
mod long;
mod lugre;
mod narrow;
mod resonance;
mod reversals;
mod stiff;
mod waveforms;
mod wrap;

use contact::tally::Ratios;
use contact::{Problem, SolveError, State, Tally, linexp, rk4};

/// How much is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// All periods of the case.
    Full,
    /// As much as a test may take: the longest case is a tenth as long.
    Quick,
}

/// A problem that is hard to integrate.
pub struct Case {
    /// Name of the case, in a few words.
    pub name: &'static str,
    /// Function that runs the case.
    pub run: fn(Scale) -> Result<Found, SolveError>,
}

/// Results of a hard case.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// What is hard about it.
    pub problem: &'static str,
    /// What the thesis's method does.
    pub naive: String,
    /// What the chosen method does.
    pub chosen: String,
    /// Invariants that must hold.
    pub checks: Vec<Check>,
}

impl Found {
    /// Whether all invariants hold.
    pub fn holds(&self) -> bool {
        self.checks.iter().all(Check::holds)
    }
}

/// An invariant: a number found and where it must lie.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What the number is.
    pub what: String,
    /// Value that was found.
    pub found: f64,
    /// The least and the most that it may be.
    pub within: (f64, f64),
}

impl Check {
    /// A number's size must not be above a bound.
    pub fn at_most(what: impl Into<String>, found: f64, most: f64) -> Self {
        Check { what: what.into(), found: found.abs(), within: (0.0, most) }
    }

    /// A number must lie between two.
    pub fn between(what: impl Into<String>, found: f64, least: f64, most: f64) -> Self {
        Check { what: what.into(), found, within: (least, most) }
    }

    /// Friction comes up to its bound, and never beyond.
    pub fn bounded(tally: &Tally) -> Self {
        Check::between("largest |F| / Fc", tally.peak_force_ratio, 0.99, 1.0 + 1e-12)
    }

    /// Two counts must be the same.
    pub fn same(what: impl Into<String>, found: u64, expected: u64) -> Self {
        Check { what: what.into(), found: found as f64, within: (expected as f64, expected as f64) }
    }

    /// Whether the value is within its bounds. A NaN is not.
    pub fn holds(&self) -> bool {
        self.found >= self.within.0 && self.found <= self.within.1
    }
}

impl std::fmt::Display for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Check { what, found, within: (least, most) } = self;
        if least == most {
            write!(f, "{what}: {found} (must be {most})")
        } else if *least == 0.0 && *most < 0.1 {
            write!(f, "{what}: {found:.1e} (<= {most:.0e})")
        } else if *least == 0.0 {
            write!(f, "{what}: {found:.5} (<= {most})")
        } else if most.is_infinite() {
            write!(f, "{what}: {found:.5} (>= {least})")
        } else {
            write!(f, "{what}: {found:.5} ({least} to {most})")
        }
    }
}

/// All hard cases of the bench.
pub static CASES: [Case; 36] = [
    Case { name: "Kt x 1e3", run: |_| stiff::contact(1e3) },
    Case { name: "Kt x 3e3", run: |_| stiff::contact(3e3) },
    Case { name: "Kt x 1e4", run: |_| stiff::contact(1e4) },
    Case { name: "Kt x 1e5", run: |_| stiff::contact(1e5) },
    Case { name: "Kt x 1e6", run: |_| stiff::contact(1e6) },
    Case { name: "mu 1e-6", run: |_| stiff::slippery(1e-6) },
    Case { name: "mu 1e-9", run: |_| stiff::slippery(1e-9) },
    Case { name: "mu 1e-12", run: |_| stiff::slippery(1e-12) },
    Case { name: "no sliding, from rest", run: |_| reversals::no_sliding_from_rest() },
    Case { name: "no sliding, steady", run: |_| reversals::no_sliding_steady() },
    Case { name: "grazing, xi 0.9", run: |_| reversals::grazing(0.9) },
    Case { name: "grazing, xi 1.0", run: |_| reversals::grazing(1.0) },
    Case { name: "xi 1.0 from the steady motion", run: |_| reversals::touching() },
    Case { name: "xi 1.0, motion given", run: |_| reversals::touching_given_motion() },
    Case { name: "resonance, no friction", run: |_| resonance::undamped_without_friction() },
    Case { name: "resonance, friction", run: |_| resonance::undamped_with_friction() },
    Case { name: "damped resonance, no friction", run: |_| resonance::damped_without_friction() },
    Case { name: "damped resonance, friction", run: |_| resonance::damped_with_friction() },
    Case { name: "a million periods", run: long::to_the_steady_state },
    Case { name: "a million periods, motion", run: long::drift },
    Case { name: "load x 0.2", run: |_| load::step(0.2, 0.500_253_255, 1e-10) },
    Case { name: "load x 2", run: |_| load::step(2.0, 0.681_684_331, 1e-12) },
    Case { name: "load x 1e-3", run: |_| load::step(1e-3, 0.341_188_186, 1e-6) },
    Case { name: "square force", run: |_| waveforms::square() },
    Case { name: "chirp through resonance", run: |_| waveforms::chirp() },
    Case { name: "f32, a thousand periods", run: |_| narrow::single(1_000) },
    Case { name: "f32, ten thousand periods", run: |_| narrow::single(10_000) },
    Case { name: "stiff LuGre", run: |_| lugre::stiff() },
    Case { name: "LuGre, sigma1 1e7", run: |_| lugre::damped() },
    Case { name: "across the sliding, kappa 1e10", run: |_| directions::in_plane(90.0, 0.5) },
    Case { name: "a degree off the line, xi 1.0", run: |_| directions::in_plane(1.0, 1.0) },
    Case { name: "compliant, A 1e3", run: |_| directions::parted() },
    Case { name: "compliant, near critical speed", run: |_| directions::near_critical() },
    Case { name: "radial ring, barely sliding", run: |_| wrap::barely_sliding(1e-6) },
    Case { name: "ring half a degree out of plane", run: |_| wrap::barely_out_of_plane() },
    Case { name: "ring, fitted normal part", run: |_| wrap::fitted() },
];

/// Steps a period of the thesis.
const THESIS_STEPS: u32 = 1000;

/// Mean friction ratio of a run.
fn mean(problem: &Problem, tally: &Tally) -> f64 {
    Ratios::of(problem, tally).friction
}

/// linexp as fast as it can; tally and mean friction ratio.
fn linexp(problem: &Problem, steps: u32, order: u32) -> Result<(Tally, f64), SolveError> {
    let tally = linexp::run(problem, steps, order, linexp::Options::Plain, &mut |_| ())?;
    Ok((tally, mean(problem, &tally)))
}

/// The thesis's method at its step, in words: how far its mean is off a reference, or when it diverged.
fn thesis(problem: &Problem, reference: f64) -> Result<String, SolveError> {
    naive(problem, THESIS_STEPS, reference)
}

fn naive(problem: &Problem, steps: u32, reference: f64) -> Result<String, SolveError> {
    match rk4::run(problem, steps, &mut |_| ()) {
        Ok(tally) => Ok(format!("n = {steps}: mean off by {:.1e}", mean(problem, &tally) - reference)),
        Err(SolveError::Diverged { time_s, .. }) => {
            Ok(format!("n = {steps}: diverges in period {:.1}", time_s * problem.waveform.frequency_hz()))
        }
        Err(error) => Err(error),
    }
}

/// Whether the thesis's method at its step comes to the end.
fn thesis_survives(problem: &Problem) -> bool {
    rk4::run(problem, THESIS_STEPS, &mut |_| ()).is_ok()
}

/// The last state of a run.
fn last(run: impl FnOnce(&mut dyn FnMut(&State)) -> Result<Tally, SolveError>) -> Result<(State, Tally), SolveError> {
    let mut last = State::default();
    let tally = run(&mut |state| last = *state)?;
    Ok((last, tally))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn every_invariant_holds() {
        let failures: Vec<String> = CASES
            .par_iter()
            .flat_map_iter(|case| match (case.run)(Scale::Quick) {
                Ok(found) => {
                    println!("{}: {} | {}", case.name, found.naive, found.chosen);
                    let failed: Vec<&Check> = found.checks.iter().filter(|check| !check.holds()).collect();
                    failed.into_iter().map(|check| format!("{}: {check}", case.name)).collect::<Vec<_>>()
                }
                Err(error) => vec![format!("{}: {error}", case.name)],
            })
            .collect();
        assert!(failures.is_empty(), "{failures:#?}");
    }

    #[test]
    fn what_is_no_number_fails() {
        assert!(!Check::at_most("", f64::NAN, 1.0).holds());
        assert!(!Check::between("", f64::NAN, 0.0, 1.0).holds());
        assert!(!Check::same("", 3, 4).holds() && Check::same("", 4, 4).holds());
    }
}
