//! A target of fuzzing: it feeds the inputs of a seed, and counts the outcomes.

use std::any::Any;
use std::collections::BTreeMap;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

/// A target of fuzzing.
pub(super) struct Target {
    /// Name of the target.
    pub(super) name: &'static str,
    /// Kind of its input, in a few words.
    pub(super) what: &'static str,
    /// Number of seeds for each million bytes over the link.
    pub(super) seeds_per_million: u64,
    /// Feeds the inputs of a seed; an error describes a violation.
    pub(super) feed: fn(u64, &mut Tally) -> Result<(), String>,
    /// Feeds the corpus.
    pub(super) corpus: fn(&mut Tally) -> Result<(), String>,
}

/// Counts of inputs and outcomes.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Number of inputs.
    pub(super) inputs: u64,
    /// Number of bytes of all inputs.
    pub(super) bytes: u64,
    /// Number of times each outcome was reached.
    pub(super) outcomes: BTreeMap<String, u64>,
}

impl Tally {
    /// Counts an input of `bytes` bytes.
    pub(super) fn input(&mut self, bytes: usize) {
        self.inputs += 1;
        self.bytes += bytes as u64;
    }

    /// Counts an outcome.
    pub(super) fn outcome(&mut self, kind: &str) {
        match self.outcomes.get_mut(kind) {
            Some(count) => *count += 1,
            None => drop(self.outcomes.insert(kind.to_owned(), 1)),
        }
    }

    fn add(&mut self, other: Tally) {
        self.inputs += other.inputs;
        self.bytes += other.bytes;
        other.outcomes.into_iter().for_each(|(kind, count)| *self.outcomes.entry(kind).or_default() += count);
    }
}

impl Target {
    /// Returns the number of seeds for this number of million bytes over the link.
    pub(super) fn seeds(&self, millions: u32) -> u64 {
        self.seeds_per_million * u64::from(millions)
    }

    /// Feeds the corpus and these seeds, and returns the counts and the failures; `None` if
    /// stopped.
    pub(super) fn run(&self, seeds: Range<u64>, stop: Option<&AtomicBool>) -> Option<(Tally, Vec<String>)> {
        let mut all = Tally::default();
        let corpus = caught(&mut all, self.corpus).map_err(|failure| format!("{}, corpus: {failure}", self.name));
        let mut failures: Vec<String> = corpus.err().into_iter().collect();
        let one = |seed: u64| {
            if stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
                return None;
            }
            let mut tally = Tally::default();
            let fed = caught(&mut tally, |tally| (self.feed)(seed, tally));
            Some((tally, fed.err().map(|failure| format!("{}, --seed {seed}: {failure}", self.name))))
        };
        for (tally, failure) in seeds.into_par_iter().map(one).collect::<Option<Vec<_>>>()? {
            all.add(tally);
            failures.extend(failure);
        }
        Some((all, failures))
    }
}

/// Feeds input, and turns a panic into a failure.
fn caught(tally: &mut Tally, feed: impl FnOnce(&mut Tally) -> Result<(), String>) -> Result<(), String> {
    catch_unwind(AssertUnwindSafe(|| feed(tally))).unwrap_or_else(|panic| Err(format!("a panic: {}", panic_message(&*panic))))
}

/// Returns the message of a panic.
fn panic_message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("without a message")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A target that panics at one seed and fails at another.
    const TARGET: Target = Target {
        name: "odd",
        what: "numbers",
        seeds_per_million: 1,
        feed: |seed, tally| {
            tally.input(8);
            assert_ne!(seed, 3, "three");
            if seed == 5 {
                return Err("five".into());
            }
            tally.outcome("fine");
            Ok(())
        },
        corpus: |_| Ok(()),
    };

    #[test]
    fn failures_are_reported_by_seed_and_the_rest_runs() {
        let (tally, failures) = TARGET.run(0..8, None).unwrap();
        assert_eq!((tally.inputs, tally.bytes, tally.outcomes["fine"]), (8, 64, 6));
        assert!(failures[0].starts_with("odd, --seed 3: a panic: ") && failures[0].contains("three"), "{failures:?}");
        assert_eq!(failures[1..], ["odd, --seed 5: five"]);
    }

    #[test]
    fn a_stop_ends_it() {
        assert!(TARGET.run(0..2, Some(&AtomicBool::new(true))).is_none());
    }
}
