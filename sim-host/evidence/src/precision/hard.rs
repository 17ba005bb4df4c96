//! Hard cases: the result of the thesis's method, the result of the chosen method, and the
//! invariants.
//!
//! The command and the test below run the same list: a failed check is a failed test.

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

/// Size of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// All periods of the case.
    Full,
    /// Few enough for a test: the longest case has a tenth of its periods.
    Quick,
}

/// A problem that is hard to integrate.
pub struct HardCase {
    /// Name of the case, in a few words.
    pub name: &'static str,
    /// Function that runs the case.
    pub run: fn(Scale) -> Result<HardResult, SolveError>,
}

/// Results of a hard case.
#[derive(Clone, Debug, PartialEq)]
pub struct HardResult {
    /// Difficulty of the case.
    pub problem: &'static str,
    /// Result of the thesis's method.
    pub naive: String,
    /// Result of the chosen method.
    pub chosen: String,
    /// Invariants that must hold.
    pub checks: Vec<Check>,
}

impl HardResult {
    /// Returns `true` if all invariants hold.
    pub fn holds(&self) -> bool {
        self.checks.iter().all(Check::holds)
    }
}

/// Invariant: a number and its bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Name of the number.
    pub what: String,
    /// Value that was found.
    pub found: f64,
    /// Lower and upper bound.
    pub within: (f64, f64),
}

impl Check {
    /// Bounds the absolute value of a number.
    pub fn at_most(what: impl Into<String>, found: f64, most: f64) -> Self {
        Check { what: what.into(), found: found.abs(), within: (0.0, most) }
    }

    /// Bounds a number on both sides.
    pub fn between(what: impl Into<String>, found: f64, least: f64, most: f64) -> Self {
        Check { what: what.into(), found, within: (least, most) }
    }

    /// Requires that friction reaches its bound and never exceeds it.
    pub fn bounded(tally: &Tally) -> Self {
        Check::between("largest |F| / Fc", tally.peak_force_ratio, 0.99, 1.0 + 1e-12)
    }

    /// Requires equal counts.
    pub fn same(what: impl Into<String>, found: u64, expected: u64) -> Self {
        Check { what: what.into(), found: found as f64, within: (expected as f64, expected as f64) }
    }

    /// Returns `true` if the value is within its bounds; `false` for NaN.
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
pub static CASES: [HardCase; 36] = [
    HardCase { name: "Kt x 1e3", run: |_| stiff::contact(1e3) },
    HardCase { name: "Kt x 3e3", run: |_| stiff::contact(3e3) },
    HardCase { name: "Kt x 1e4", run: |_| stiff::contact(1e4) },
    HardCase { name: "Kt x 1e5", run: |_| stiff::contact(1e5) },
    HardCase { name: "Kt x 1e6", run: |_| stiff::contact(1e6) },
    HardCase { name: "mu 1e-6", run: |_| stiff::slippery(1e-6) },
    HardCase { name: "mu 1e-9", run: |_| stiff::slippery(1e-9) },
    HardCase { name: "mu 1e-12", run: |_| stiff::slippery(1e-12) },
    HardCase { name: "no sliding, from rest", run: |_| reversals::no_sliding_from_rest() },
    HardCase { name: "no sliding, steady", run: |_| reversals::no_sliding_steady() },
    HardCase { name: "grazing, xi 0.9", run: |_| reversals::grazing(0.9) },
    HardCase { name: "grazing, xi 1.0", run: |_| reversals::grazing(1.0) },
    HardCase { name: "xi 1.0 from the steady motion", run: |_| reversals::touching() },
    HardCase { name: "xi 1.0, prescribed motion", run: |_| reversals::touching_given_motion() },
    HardCase { name: "resonance, no friction", run: |_| resonance::undamped_without_friction() },
    HardCase { name: "resonance, friction", run: |_| resonance::undamped_with_friction() },
    HardCase { name: "damped resonance, no friction", run: |_| resonance::damped_without_friction() },
    HardCase { name: "damped resonance, friction", run: |_| resonance::damped_with_friction() },
    HardCase { name: "a million periods", run: long::to_the_steady_state },
    HardCase { name: "a million periods, motion", run: long::drift },
    HardCase { name: "load x 0.2", run: |_| load::step(0.2, 0.500_253_255, 1e-10) },
    HardCase { name: "load x 2", run: |_| load::step(2.0, 0.681_684_331, 1e-12) },
    HardCase { name: "load x 1e-3", run: |_| load::step(1e-3, 0.341_188_186, 1e-6) },
    HardCase { name: "square force", run: |_| waveforms::square() },
    HardCase { name: "chirp through resonance", run: |_| waveforms::chirp() },
    HardCase { name: "f32, a thousand periods", run: |_| narrow::single(1_000) },
    HardCase { name: "f32, ten thousand periods", run: |_| narrow::single(10_000) },
    HardCase { name: "stiff LuGre", run: |_| lugre::stiff() },
    HardCase { name: "LuGre, sigma1 1e7", run: |_| lugre::damped() },
    HardCase { name: "across the sliding, kappa 1e10", run: |_| directions::in_plane(90.0, 0.5) },
    HardCase { name: "one degree from the sliding direction, xi 1.0", run: |_| directions::in_plane(1.0, 1.0) },
    HardCase { name: "compliant, A 1e3", run: |_| directions::parted() },
    HardCase { name: "compliant, near critical speed", run: |_| directions::near_critical() },
    HardCase { name: "radial ring, barely sliding", run: |_| wrap::barely_sliding(1e-6) },
    HardCase { name: "ring half a degree out of plane", run: |_| wrap::barely_out_of_plane() },
    HardCase { name: "ring, fitted normal part", run: |_| wrap::fitted() },
];

/// Steps a period of the thesis.
const THESIS_STEPS: u32 = 1000;

/// Returns the mean friction ratio of a run.
fn mean(problem: &Problem, tally: &Tally) -> f64 {
    Ratios::of(problem, tally).friction
}

/// Runs linexp in its fastest form; returns tally and mean friction ratio.
fn linexp(problem: &Problem, steps: u32, order: u32) -> Result<(Tally, f64), SolveError> {
    let tally = linexp::run(problem, steps, order, linexp::Options::Plain, &mut |_| ())?;
    Ok((tally, mean(problem, &tally)))
}

/// Describes the thesis's method at its step: its deviation of the mean from a reference, or when
/// it diverged.
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

/// Returns `true` if the thesis's method completes the run at its step.
fn thesis_survives(problem: &Problem) -> bool {
    rk4::run(problem, THESIS_STEPS, &mut |_| ()).is_ok()
}

/// Returns the last state and the tally of a run.
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
    fn nan_and_unequal_counts_fail() {
        assert!(!Check::at_most("", f64::NAN, 1.0).holds());
        assert!(!Check::between("", f64::NAN, 0.0, 1.0).holds());
        assert!(!Check::same("", 3, 4).holds() && Check::same("", 4, 4).holds());
    }
}
