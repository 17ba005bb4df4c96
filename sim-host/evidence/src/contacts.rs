//! Random contacts: does `auto` keep its word, and what does it cost beside the cheapest setting that would have done?
//!
//! ```text
//! contact (draw) --> Taylor series with located reversals --+--> judged at every tolerance --> tables, contacts.csv
//!                --> `auto`, as a cell of a grid asks it ---+
//!                --> `auto` for the whole record, as shown -+
//! ```
//!
//! Compliant contacts under vibration across them are a law of their own, with arcs instead of methods and a reference of their own (`compliant`).

mod compliant;
mod cost;
mod draw;
mod in_plane;
mod judged;
mod tables;

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use self::draw::{Contact, Friction};
use self::judged::{Judged, RecordTruth, Truth};
use crate::evidence::{Error, Evidence, Options};
use contact::Problem;
use report::Report;
use sim::study::StudyError;

/// Contacts of a law, and those of the quick variant, where no other number is given.
const SET: [u32; 2] = [1000, 100];
/// One of so many of the first so many is timed.
const TIMED: usize = 7;
const TIMED_OF: usize = 1000;
/// The tolerances that are asked.
const TOLERANCES: [f64; 6] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-12];
/// And those that are asked of the whole record.
const RECORD_TOLERANCES: [f64; 4] = [1e-3, 1e-5, 1e-7, 1e-9];

/// A contact, and what `auto` says of it.
struct Tried {
    friction: Friction,
    contact: Contact,
    truth: Option<Truth>,
    answers: Vec<Judged>,
    records: Vec<Judged>,
}

/// Judges `auto`.
pub(crate) fn run(options: &mut Options) -> Result<Evidence, Error> {
    let number = options.count.unwrap_or(SET[usize::from(options.quick)]);
    let (stop, seed) = (options.stop, options.seed.unwrap_or(0));
    let try_one = |(friction, number): (Friction, u32)| {
        if stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Err(StudyError::Interrupted.into());
        }
        let contact = Contact::draw(number, friction, seed);
        let (answers, truth) = answers(&contact);
        let records = if Friction::RECORDED.contains(&friction) { records(&contact.problem) } else { Vec::new() };
        Ok(Tried { friction, contact, truth, answers, records })
    };
    let mut set = Vec::new();
    for friction in Friction::ALL {
        (options.progress)(&format!("{number} contacts, {}", friction.name()));
        let tried = (0..number).into_par_iter().map(|number| try_one((friction, number)));
        set.extend(tried.collect::<Result<Vec<Tried>, Error>>()?);
    }
    (options.progress)("cost beside the cheapest setting");
    let costs = cost::of(set.iter().filter(|tried| tried.friction == Friction::Dahl).take(TIMED_OF).step_by(TIMED));
    (options.progress)(&format!("{number} contacts, compliant across"));
    let across = compliant::compare(number, seed)?;
    let tables = [tables::tables(&set, &costs), vec![compliant::table(&across)], compliant::model::tables()].concat();
    Ok(Evidence {
        report: Report {
            title: "Random contacts: does `auto` keep its word?".into(),
            tables: tables.clone(),
            ..Report::default()
        },
        files: vec![
            ("contacts.csv", tables::csv(&set)?),
            ("costs.csv", tables::costs_csv(&costs)?),
            ("compliant.csv", compliant::csv(&across)?),
        ],
        docs: tables,
        missed: [tables::missed(&set, &costs), compliant::missed(&across)].concat(),
        ..Evidence::default()
    })
}

/// The means by `auto` at every tolerance, and the truth.
fn answers(contact: &Contact) -> (Vec<Judged>, Option<Truth>) {
    let problem = &contact.problem;
    if let Some(direction) = contact.direction {
        let truth = in_plane::truth(problem, direction).map(|(friction, unknown)| Truth { friction, unknown });
        let judged = |&tolerance: &f64| Judged::of_plane(problem, direction, truth.as_ref(), tolerance);
        return (TOLERANCES.iter().map(judged).collect(), truth);
    }
    let truth = Truth::of(problem).ok();
    (TOLERANCES.iter().map(|&tolerance| Judged::of(problem, truth.as_ref(), tolerance)).collect(), truth)
}

/// The records.
fn records(problem: &Problem) -> Vec<Judged> {
    let truth = RecordTruth::of(problem).ok();
    RECORD_TOLERANCES.iter().map(|&tolerance| Judged::of_record(problem, truth.as_ref(), tolerance)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contacts that were once silently off, or whose stated error was too low by more than ten.
    #[test]
    fn contacts_that_it_was_wrong_about() {
        let found = [
            (Friction::Lugre, 870, "a fast oscillator without damping under Runge-Kutta, a short record seen at its end"),
            (
                Friction::Lugre,
                835,
                "damped bristles hold a mass near its resonance: what a run is off by grows by a power of ten in a few periods",
            ),
            (
                Friction::Dahl,
                979,
                "friction of a third of the force holds the mass: two runs agreed on what they were both off by",
            ),
            (Friction::Dahl, 409, "a mass on a soft spring that only reverses when it has come back"),
            (Friction::Dahl, 166, "a mass that its friction pumps"),
            (Friction::Dahl, 364, "a fast oscillator without damping under stiff bristles, seen at the end of the record"),
            (Friction::Dahl, 385, "the same, whose error grows by the same in every period"),
            (Friction::Dahl, 773, "the same, with a stiff contact"),
            (Friction::Dahl, 957, "the same, with bristles as long as a tenth of the vibration"),
            (Friction::Dahl, 679, "a damped mass under a stiff contact"),
            (Friction::Dahl, 785, "a given motion of stiff bristles"),
            (Friction::Dahl, 2220, "a given motion in steps of order two, each many bristles long"),
            (Friction::Dahl, 8677, "the same of a sawtooth"),
            (Friction::Dahl, 5458, "short bristles on which a mass rings, two runs of linexp agreed on what both were off by"),
            (Friction::Dahl, 7181, "the same, of a mass on a soft spring"),
            (Friction::Dahl, 9055, "the same, over 165 periods"),
            (Friction::Dahl, 7037, "a mass 0.2 % beside its resonance, whose first periods have nothing of the beat"),
            (Friction::Lugre, 3119, "a narrow Stribeck peak between the steps of Runge-Kutta"),
            (Friction::Lugre, 5685, "a chirp with damped bristles that never reverses"),
            (Friction::Lugre, 7798, "a Stribeck peak under a mass that friction moves"),
            (Friction::Lugre, 8826, "a Stribeck peak of a seventh of the vibration"),
            (Friction::Lugre, 1812, "a series that ended within a Stribeck peak of which it had nothing"),
            (Friction::Lugre, 3985, "the same under damped bristles"),
            (Friction::Lugre, 4922, "the same in a chirp"),
            (Friction::Lugre, 7335, "the same with bristles as damped as to hold"),
            (Friction::Lugre, 9068, "the same under a random force"),
            (Friction::Lugre, 6825, "the same under a sawtooth"),
            (Friction::Lugre, 7324, "the same under a square force"),
            (Friction::Lugre, 2901, "the same under a triangle"),
        ];
        for (friction, number, what) in found {
            let contact = Contact::draw(number, friction, 0);
            for judged in answers(&contact).0.iter().chain(&records(&contact.problem)) {
                assert!(!judged.is_silent() && !judged.is_low_by(10.0), "{number}, {what}: {judged:?}");
            }
        }
    }

    /// Contacts whose record grows what it is off by: a tolerance of it is met, or said not to be.
    #[test]
    fn records_that_lose_their_way_say_so() {
        let found = [
            (Friction::Lugre, 835, "damped bristles that hold a mass near its resonance"),
            (Friction::Lugre, 164, "damped bristles under a force that jumps"),
        ];
        for (friction, number, what) in found {
            let contact = Contact::draw(number, friction, 0);
            let records = records(&contact.problem);
            assert!(
                records.iter().any(|judged| judged.verdict == judged::Verdict::Unknown || judged.is_flagged()),
                "{records:?}"
            );
            for judged in &records {
                assert!(!judged.is_silent() && !judged.is_low_by(10.0), "{number}, {what}: {judged:?}");
            }
        }
    }

    #[test]
    fn docs_of_normal_vibration_have_these_numbers() {
        let command = "cargo test -p sonoglide-evidence normal_vibration";
        report::docs::block("normal-vibration.md", command, &report::markdown(&compliant::model::tables()));
    }

    /// None of so many of each law is silently off, low by ten, or without a reason. How many are flagged, how high estimates are and what they
    /// cost stands in docs/evidence/precision.md.
    fn keeps_its_word(count: u32) {
        let mut options =
            Options { quick: true, count: Some(count), seed: None, counted: None, stop: None, progress: &mut |_| () };
        let evidence = run(&mut options).unwrap_or_else(|error| panic!("{error}"));
        let word = ["silently off", "without advice", "low by 10", "compliant"];
        let missed: Vec<_> = evidence.missed.iter().filter(|missed| word.iter().any(|word| missed.contains(word))).collect();
        assert!(missed.is_empty(), "{missed:#?}");
    }

    #[test]
    fn auto_keeps_its_word() {
        keeps_its_word(SET[1] / 3);
    }

    /// All of the quick variant.
    #[test]
    #[ignore = "takes minutes"]
    fn auto_keeps_its_word_in_the_quick_variant() {
        keeps_its_word(SET[1]);
    }
}
