//! The complete measurement, from the reference to the hard cases.

use super::claims::{self, Claim};
use super::hard::{CASES, HardCase, HardResult, Scale};
use super::instructions;
use super::reference::{self, NoReference, Reference};
use super::work::{self, Curve};
use crate::evidence::Options;
use contact::SolveError;
use contact::table_4_1;

/// Results of the work-precision study.
pub struct Study {
    /// `true` for a quick measurement.
    pub quick: bool,
    /// Number of rounds of timing.
    pub rounds: u32,
    /// Reference solution for the errors.
    pub reference: Reference,
    /// Work and precision of every method.
    pub curves: Vec<Curve>,
    /// Reason why there are no instruction counts.
    pub uncounted: Option<String>,
    /// Claims with their results.
    pub claims: Vec<Claim>,
    /// The hard cases, in order.
    pub hard: Vec<(&'static HardCase, Result<HardResult, SolveError>)>,
}

impl Study {
    /// Returns `true` if every invariant of the hard cases holds.
    pub fn passes(&self) -> bool {
        self.hard.iter().all(|(_, found)| found.as_ref().is_ok_and(HardResult::holds))
    }
}

const ROUNDS: u32 = 15;
const QUICK_ROUNDS: u32 = 3;

/// Measures work and precision of all methods.
pub fn measure(options: &mut Options) -> Result<Study, NoReference> {
    let Options { quick, counted, progress: say, .. } = options;
    let (quick, counted) = (*quick, *counted);
    say("reference");
    let reference = reference::make(&table_4_1::standard())?;
    say("errors");
    let mut curves = work::errors(&reference, quick)?;
    let rounds = if quick { QUICK_ROUNDS } else { ROUNDS };
    for round in 1..=rounds {
        say(&format!("times, round {round} of {rounds}"));
        work::round(&mut curves)?;
    }
    say("instructions");
    let uncounted = match counted {
        Some((executable, options)) => {
            instructions::count(&mut curves, executable, options).err().map(|reason| reason.to_string())
        }
        None => Some("not requested".into()),
    };
    say("hard cases");
    let scale = if quick { Scale::Quick } else { Scale::Full };
    // Sequential, as some of them report their time.
    let hard = CASES.iter().map(|case| (case, (case.run)(scale))).collect();
    let claims = claims::judge(&curves);
    Ok(Study { quick, rounds, reference, curves, uncounted, claims, hard })
}
