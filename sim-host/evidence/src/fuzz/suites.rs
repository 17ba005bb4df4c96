//! Suites of users: a changed text is refused with a reason, or is a suite whose cases can be
//! listed.

use hal_mock::chance::Chance;
use scene::builtin;
use scene::load::LoadError;
use scene::suite::load_text;

use super::corpus;
use super::target::{Tally, Target};
use super::text::{changed, kind, kinds, pick};
use crate::bench::BENCHES;

pub(super) const TARGET: Target = Target {
    name: "suites",
    what: "texts of suites",
    seeds_per_million: 10,
    feed,
    corpus: |tally| corpus::SUITES.iter().try_for_each(|(name, text)| judge(name, text, tally)),
};

/// Number of texts of each seed.
const TEXTS: usize = 10;

fn feed(seed: u64, tally: &mut Tally) -> Result<(), String> {
    let mut chance = Chance::new(seed);
    let small: Vec<&str> = corpus::SUITES.iter().map(|(_, text)| *text).collect();
    let built_in = BENCHES.iter().filter_map(|bench| bench.suite);
    let texts: Vec<&str> = built_in.chain(small.iter().copied()).collect();
    for _ in 0..TEXTS {
        // The built-in ones are long, so the small ones are used more often.
        let among = if chance.strikes(0.7) { &small } else { &texts };
        let text = pick(&mut chance, among).unwrap_or_default();
        let other =
            if chance.strikes(0.5) { pick(&mut chance, &texts) } else { pick(&mut chance, builtin::all()).map(|(_, text)| text) };
        judge("fuzzed.toml", &changed(&mut chance, text, other.unwrap_or_default(), &[]), tally)?;
    }
    Ok(())
}

fn judge(name: &str, text: &str, tally: &mut Tally) -> Result<(), String> {
    tally.input(text.len());
    for quick in [false, true] {
        match load_text(name, text, quick) {
            Ok(loaded) if loaded.cases.iter().all(|case| case.command.is_empty()) => {
                return Err(format!("a suite without a case:\n{text}"));
            }
            Ok(_) => tally.outcome("a suite"),
            Err(LoadError::Invalid(report)) => {
                kinds(&report).map_err(|failure| format!("{failure}\n{text}"))?.iter().for_each(|kind| tally.outcome(kind));
            }
            Err(error) => tally.outcome(&kind(&error.to_string())),
        }
    }
    Ok(())
}
