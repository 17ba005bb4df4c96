//! A target of fuzzing: what is fed, by seeds, and what was seen of it.

use std::any::Any;
use std::collections::BTreeMap;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

/// What is fed.
pub(super) struct Target {
    /// Name of the target.
    pub(super) name: &'static str,
    /// What is fed, in a few words.
    pub(super) what: &'static str,
    /// Seeds for each million bytes over the link.
    pub(super) seeds_per_million: u64,
    /// Feeds what belongs to a seed; an error says what it must not have done.
    pub(super) feed: fn(u64, &mut Seen) -> Result<(), String>,
    /// Feeds the corpus.
    pub(super) corpus: fn(&mut Seen) -> Result<(), String>,
}

/// What was fed, and what it came to.
#[derive(Debug, Default)]
pub(super) struct Seen {
    /// Inputs.
    pub(super) inputs: u64,
    /// Their bytes.
    pub(super) bytes: u64,
    /// Outcomes, and how often each was reached.
    pub(super) outcomes: BTreeMap<String, u64>,
}

impl Seen {
    /// Counts an input of so many bytes.
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

    fn add(&mut self, other: Seen) {
        self.inputs += other.inputs;
        self.bytes += other.bytes;
        other.outcomes.into_iter().for_each(|(kind, count)| *self.outcomes.entry(kind).or_default() += count);
    }
}

impl Target {
    /// How many seeds belong to so many million bytes over the link.
    pub(super) fn seeds(&self, millions: u32) -> u64 {
        self.seeds_per_million * u64::from(millions)
    }

    /// Feeds the corpus and these seeds; what was seen, and the failures. None where it was stopped.
    pub(super) fn run(&self, seeds: Range<u64>, stop: Option<&AtomicBool>) -> Option<(Seen, Vec<String>)> {
        let mut all = Seen::default();
        let corpus = caught(&mut all, self.corpus).map_err(|failure| format!("{}, corpus: {failure}", self.name));
        let mut failures: Vec<String> = corpus.err().into_iter().collect();
        let one = |seed: u64| {
            if stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
                return None;
            }
            let mut seen = Seen::default();
            let fed = caught(&mut seen, |seen| (self.feed)(seed, seen));
            Some((seen, fed.err().map(|failure| format!("{}, --seed {seed}: {failure}", self.name))))
        };
        for (seen, failure) in seeds.into_par_iter().map(one).collect::<Option<Vec<_>>>()? {
            all.add(seen);
            failures.extend(failure);
        }
        Some((all, failures))
    }
}

/// Feeds; a panic is a failure as any other.
fn caught(seen: &mut Seen, feed: impl FnOnce(&mut Seen) -> Result<(), String>) -> Result<(), String> {
    catch_unwind(AssertUnwindSafe(|| feed(seen))).unwrap_or_else(|panic| Err(format!("a panic: {}", said(&*panic))))
}

/// What a panic says.
fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("without a word")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What panics at one seed, and refuses another.
    const TARGET: Target = Target {
        name: "odd",
        what: "numbers",
        seeds_per_million: 1,
        feed: |seed, seen| {
            seen.input(8);
            assert_ne!(seed, 3, "three");
            if seed == 5 {
                return Err("five".into());
            }
            seen.outcome("fine");
            Ok(())
        },
        corpus: |_| Ok(()),
    };

    #[test]
    fn panics_and_failures_are_named_by_their_seeds_and_the_rest_goes_on() {
        let (seen, failures) = TARGET.run(0..8, None).unwrap();
        assert_eq!((seen.inputs, seen.bytes, seen.outcomes["fine"]), (8, 64, 6));
        assert!(failures[0].starts_with("odd, --seed 3: a panic: ") && failures[0].contains("three"), "{failures:?}");
        assert_eq!(failures[1..], ["odd, --seed 5: five"]);
    }

    #[test]
    fn a_stop_ends_it() {
        assert!(TARGET.run(0..2, Some(&AtomicBool::new(true))).is_none());
    }
}
