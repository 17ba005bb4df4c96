//! Invalid scenes of all kinds, and their messages.

mod angle;
mod belt;
mod carriage;
mod comparison;
mod design;
mod distribution;
mod dring;
mod excited;
mod heat;
mod keys;
mod kinds;
mod layers;
mod motor;
mod numbers;
mod profile;
mod rules;
mod vary;
mod whole;

use super::load::load_text;
use super::{Controller, Scene};

/// Returns a scene for these tests only, so that its line numbers do not change.
fn example() -> &'static str {
    include_str!("tests/example.toml")
}

fn sets(sets: &[&str]) -> Vec<String> {
    sets.iter().map(|set| (*set).to_owned()).collect()
}

fn loaded(changes: &[&str]) -> Scene {
    load_text("experiment-1", example(), &sets(changes)).unwrap_or_else(|error| panic!("{error}")).scene
}

/// Returns the controller of the example with changes.
fn driven(changes: &[&str]) -> Controller {
    loaded(changes).controller.unwrap()
}

/// Returns the report on a text.
fn report(text: &str, changes: &[&str]) -> String {
    match load_text("a.toml", text, &sets(changes)) {
        Ok(_) => panic!("there is no problem in\n{text}\n{changes:?}"),
        Err(error) => error.to_string(),
    }
}

/// Returns the report on the example with one line replaced.
fn with_line(old: &str, new: &str) -> String {
    let line = example().lines().find(|line| line.starts_with(old)).unwrap_or_else(|| panic!("no line `{old}`"));
    report(&example().replacen(line, new, 1), &[])
}

fn says(report: &str, parts: &[&str]) {
    for part in parts {
        assert!(report.contains(part), "`{part}` is missing in\n{report}");
    }
}
