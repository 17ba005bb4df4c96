//! Scripts of the link and other texts that users write for it: expectations, values of settings.
//! They are parsed, not run.

use ::link::answer::Answer;
use ::link::expect::Expect;
use ::link::link_error::LinkError;
use ::link::parameter;
use ::link::script::Script;
use firmware::board::parameters::PARAMETERS;
use hal_mock::chance::Chance;
use serde_json::json;

use super::corpus;
use super::target::{Tally, Target};
use super::text::{changed, kind, kinds, pick};

pub(super) const TARGET: Target = Target {
    name: "scripts",
    what: "scripts of the link, expectations, values of settings",
    seeds_per_million: 100,
    feed,
    corpus: |tally| corpus::SCRIPTS.iter().try_for_each(|(name, text)| script(name, text, tally)),
};

/// Largest number of lines of a script.
const LINES: u64 = 12;
/// Number of single words of each seed.
const SINGLE: usize = 10;
/// Words that users may write.
const WORDS: [&str; 24] = [
    "--volts",
    "--current",
    "--for",
    "--on",
    "--off",
    "--count",
    "-o",
    "--trigger",
    "--band",
    "20k:45k",
    "--yes",
    "45k:20k",
    "nan:1",
    "expect",
    "!",
    "+-",
    "<=",
    "=",
    "0.05N",
    "configured",
    "forever",
    "1e6s",
    "--",
    "wait",
];

fn feed(seed: u64, tally: &mut Tally) -> Result<(), String> {
    let mut chance = Chance::new(seed);
    let all: Vec<&str> = corpus::SCRIPTS.iter().flat_map(|(_, text)| text.split_inclusive('\n')).collect();
    let text: String = (0..=chance.below(LINES)).filter_map(|_| pick(&mut chance, &all)).collect();
    let words: Vec<String> =
        WORDS.iter().map(|word| (*word).to_owned()).chain(PARAMETERS.iter().map(|of| of.name.to_owned())).collect();
    script("fuzzed", &changed(&mut chance, &text, &all.concat(), &words), tally)?;
    for _ in 0..SINGLE {
        single(&mut chance, &words, tally)?;
    }
    Ok(())
}

fn script(name: &str, text: &str, tally: &mut Tally) -> Result<(), String> {
    tally.input(text.len());
    match Script::parse(name, text) {
        Ok(_) => tally.outcome("a script"),
        Err(LinkError::Script(report)) => {
            kinds(&report).map_err(|failure| format!("{failure}\n{text}"))?.iter().for_each(|kind| tally.outcome(kind));
        }
        Err(error) => return Err(format!("not an error of a script: {error}\n{text}")),
    }
    Ok(())
}

/// Parses a value of a setting, and an expectation of an answer.
fn single(chance: &mut Chance, words: &[String], tally: &mut Tally) -> Result<(), String> {
    let word = pick(chance, words).unwrap_or_default();
    let word = if chance.strikes(0.5) { changed(chance, &word, "1:2k x.0.y 3", words) } else { word };
    tally.input(word.len());
    if let Some(of) = pick(chance, &PARAMETERS) {
        // The printed form of a value is read as the same value.
        match parameter::read(&of, &word) {
            Ok(value)
                if !value.is_nan() && parameter::read(&of, &parameter::shown(&of, value)).is_ok_and(|again| again != value) =>
            {
                return Err(format!("{} = {word:?} is {value}, but its printed form is another value", of.name));
            }
            Ok(_) => tally.outcome("a value"),
            Err(error) => tally.outcome(&kind(&error.to_string())),
        }
    }
    let answer = Answer::to("scan").field("q", 65.2).field("mode", "run").field("resonances", json!([{ "q": 65.0 }, [1, null]]));
    let name = pick(chance, &["q", "mode", "resonances.0.q", "resonances.1.9", "resonances.0", "."]).unwrap_or_default();
    let relation = pick(chance, &["=", "!=", "<", "<=", ">", ">=", "~"]).unwrap_or_default();
    let given = [name, relation, &word, "+-", &word];
    match Expect::parse(&given[..chance.below(6) as usize]) {
        Ok(expect) => match expect.judge(&answer) {
            Ok(_) => tally.outcome("an expectation that holds"),
            Err(error) => tally.outcome(&kind(&error.to_string())),
        },
        Err((place, why)) if place <= given.len() => tally.outcome(&kind(&why)),
        Err((place, why)) => return Err(format!("{given:?}: {why}, at {place}")),
    }
    Ok(())
}
