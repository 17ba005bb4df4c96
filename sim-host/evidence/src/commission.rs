//! Runs `sim-host link PORT commission` on the random transducers of
//! [`transducers`](crate::transducers), given only a frequency band.
//!
//! ```text
//! transducer (draw), its front end, a band --> simulated board --> `commission` --> compared with the plant --> tables, commission.csv
//! ```
//!
//! All of it is simulated (SIL).

mod judged;
mod tables;
mod watched_board;

use self::judged::{Judged, judge};
use crate::campaign::{self, count, each};
use crate::evidence::{Error, Evidence, Options};
use crate::transducers::draw::Transducer;

/// Default number of transducers, full and quick: equally many of each kind.
const TRANSDUCERS: [u32; 2] = [60, 12];
/// Fraction of the transducers that must be right and in time.
const MIN_RIGHT_REL: f64 = 0.98;

/// A transducer with the result of its commissioning.
struct Commissioned {
    transducer: Transducer,
    command: String,
    judged: Judged,
}

/// Commissions the transducers, and returns the evidence.
pub(crate) fn run(options: &mut Options) -> Result<Evidence, Error> {
    let number = options.count.unwrap_or(TRANSDUCERS[usize::from(options.quick)]);
    let first = options.seed.map(|first| first.min(u32::MAX.into()) as u32);
    let of_set = first.map_or(String::new(), |first| format!(" of the wider set, from number {first}"));
    (options.progress)(&format!("{number} transducers{of_set}"));
    let set = each(number, options.stop, |number| {
        let transducer = match first {
            Some(first) => Transducer::draw_wider(first.saturating_add(number)),
            None => Transducer::draw(number),
        };
        let (command, judged) = judge(&transducer)?;
        Ok(Commissioned { transducer, command, judged })
    })?;
    let title = format!("Commissioning: random transducers{of_set} found from a band alone");
    let subtitle = "Simulated: `sim-host link PORT commission` against the firmware on the host and the simulated stack";
    let files = vec![("commission.csv", tables::csv(&set)?)];
    Ok(campaign::evidence(&title, subtitle, tables::tables(&set), files, missed(&set)))
}

/// Returns the targets that are missed.
fn missed(set: &[Commissioned]) -> Vec<String> {
    let mut missed = Vec::new();
    let right = count(set, |tried| (tried.judged.is_right() || tried.judged.is_good()) && tried.judged.is_in_time());
    if (right as f64) < MIN_RIGHT_REL * set.len() as f64 {
        missed.push(format!("{right} of {} right or good, and in time; the target is {:.0} %", set.len(), 100.0 * MIN_RIGHT_REL));
    }
    for tried in set {
        let Judged { peak_v_rel, peak_a_rel, .. } = tried.judged;
        if tried.judged.is_silently_wrong() {
            missed.push(format!("silently wrong: {}", tried.command));
        }
        if peak_v_rel > 1.0 || peak_a_rel > 1.0 {
            missed.push(format!("too high, {peak_v_rel:.3} of the volts, {peak_a_rel:.3} of the amperes: {}", tried.command));
        }
    }
    missed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One transducer of each cause of a former failure: another scan during the average of the
    /// lock, a motional resistance below that of the source, a code above the voltage, and two
    /// fitted resonances that cancel each other.
    #[test]
    fn former_failures_are_right() {
        for number in [165, 571, 209, 442] {
            let (command, judged) = judge(&Transducer::draw(number)).unwrap();
            let is_found = judged.is_right() || judged.is_good();
            assert!(is_found && judged.peak_v_rel <= 1.0 && judged.peak_a_rel <= 1.0, "{command}");
        }
    }

    /// A mode whose apparent capacitance is negative, because of another one below it; and a
    /// clamped capacitance that draws more than the given current if the amplitude steps.
    #[test]
    fn former_failures_of_the_wider_set_are_right() {
        for number in [491, 532] {
            let (command, judged) = judge(&Transducer::draw_wider(number)).unwrap();
            assert!(judged.is_right() && judged.peak_a_rel <= 1.0, "{command}");
        }
    }

    /// The quick variant has no silently wrong result and never exceeds the voltage and current
    /// limits. docs/evidence/transducers.md gives the number of right ones.
    #[test]
    fn no_result_is_silently_wrong_or_over_its_limits() {
        let mut missed = campaign::quick(run, None).missed;
        missed.retain(|missed| !missed.contains("and in time"));
        assert_eq!(missed, [""; 0]);
    }
}
