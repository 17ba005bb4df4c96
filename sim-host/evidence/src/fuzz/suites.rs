//! Suites of a user's own: a changed text is refused by name, or is a suite with cases that can be listed.

use hal_mock::chance::Chance;
use scene::builtin;
use scene::load::LoadError;
use scene::suite::load_text;

use super::corpus;
use super::target::{Seen, Target};
use super::text::{changed, kind, kinds, pick};
use crate::bench::BENCHES;

pub(super) const TARGET: Target = Target {
    name: "suites",
    what: "texts of suites",
    seeds_per_million: 10,
    feed,
    corpus: |seen| corpus::SUITES.iter().try_for_each(|(name, text)| judge(name, text, seen)),
};

/// Texts of each seed.
const TEXTS: usize = 10;

fn feed(seed: u64, seen: &mut Seen) -> Result<(), String> {
    let mut chance = Chance::new(seed);
    let small: Vec<&str> = corpus::SUITES.iter().map(|(_, text)| *text).collect();
    let built_in = BENCHES.iter().filter_map(|bench| bench.suite);
    let texts: Vec<&str> = built_in.chain(small.iter().copied()).collect();
    for _ in 0..TEXTS {
        // The built-in ones are long: the small ones come as often as they do.
        let among = if chance.strikes(0.7) { &small } else { &texts };
        let text = pick(&mut chance, among).unwrap_or_default();
        let other =
            if chance.strikes(0.5) { pick(&mut chance, &texts) } else { pick(&mut chance, builtin::all()).map(|(_, text)| text) };
        judge("fuzzed.toml", &changed(&mut chance, text, other.unwrap_or_default(), &[]), seen)?;
    }
    Ok(())
}

fn judge(name: &str, text: &str, seen: &mut Seen) -> Result<(), String> {
    seen.input(text.len());
    for quick in [false, true] {
        match load_text(name, text, quick) {
            Ok(loaded) if loaded.cases.iter().all(|case| case.command.is_empty()) => {
                return Err(format!("a suite without a case:\n{text}"));
            }
            Ok(_) => seen.outcome("a suite"),
            Err(LoadError::Invalid(report)) => {
                kinds(&report).map_err(|failure| format!("{failure}\n{text}"))?.iter().for_each(|kind| seen.outcome(kind));
            }
            Err(error) => seen.outcome(&kind(&error.to_string())),
        }
    }
    Ok(())
}
