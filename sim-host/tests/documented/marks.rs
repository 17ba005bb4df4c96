//! Checks of numbers in prose: a mark names the source of each, and the test compares both.
//!
//! ```text
//! <!-- value: ARGUMENTS METRIC -->45.2 ms<!-- /value -->       of `sim-host ARGUMENTS --format json`
//! <!-- long value: ARGUMENTS METRIC -->...<!-- /value -->      the same of a command of minutes, in `.ci/thorough`
//! <!-- from: PAGE: TEXT -->27<!-- /from -->                    of a line in the generated blocks of a page
//! <!-- given -->     inputs, limits, defaults or published numbers; exempts the whole line
//! ```

use std::collections::BTreeMap;

use serde_json::Value;

use super::*;

/// Returns the generated blocks of a page, or all of its text if it has none.
fn generated(text: &str) -> String {
    let blocks = text.split("<!-- begin: ").skip(1).map(|rest| rest.split("<!-- end -->").next().unwrap_or(rest));
    let blocks = blocks.collect::<Vec<_>>().join("\n");
    if blocks.is_empty() { text.to_owned() } else { blocks }
}

/// Reads the numbers of a text without their signs, each with half a unit of its last digit. Joins
/// groups of thousands; skips names such as `C0`.
fn numbers(text: &str) -> Vec<(f64, f64)> {
    let text: Vec<char> = text.chars().collect();
    let is_digit = |at: usize| text.get(at).is_some_and(char::is_ascii_digit);
    let is_joint = |at: usize| {
        text[at].is_whitespace() && at > 0 && is_digit(at - 1) && (1..=3).all(|n| is_digit(at + n)) && !is_digit(at + 4)
    };
    let joined: String = (0..text.len()).filter(|&at| !is_joint(at)).map(|at| text[at]).collect();
    let number = |word: &str| {
        let word = word.trim_matches(['.', '-']);
        let (mantissa, exponent) = word.split_once('e').unwrap_or((word, "0"));
        let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let half = 0.5 * 10f64.powi(exponent.parse::<i32>().ok()? - decimals as i32);
        let value = word.parse::<f64>().ok()?;
        word.starts_with(|first: char| first.is_ascii_digit()).then_some((value, half))
    };
    joined.split(|c: char| !(c.is_alphanumeric() || "_.-".contains(c))).filter_map(number).collect()
}

#[test]
fn numbers_are_read_with_their_rounding() {
    let read = numbers("27 of 61 200, C0 2.5 at Q 65.");
    assert_eq!(read, [(27.0, 0.5), (61_200.0, 0.5), (2.5, 0.05), (65.0, 0.5)]);
}

/// Checks that each number occurs, rounded, in a line of the page's generated blocks that contains
/// TEXT, if the bars between its cells are removed.
#[test]
fn marked_numbers_are_those_of_their_page() {
    let pages = pages();
    let mut checked = 0;
    for (page, text) in &pages {
        for marked in text.split("<!-- from: ").skip(1) {
            let parts = marked.split_once(" -->").and_then(|(from, rest)| {
                let (source, row) = from.split_once(": ")?;
                Some((source, row, rest.split_once("<!-- /from -->")?.0))
            });
            let (source, row, claim) = parts.unwrap_or_else(|| panic!("{page}: incomplete mark `{marked:.60}`"));
            let table = pages.iter().find(|(name, _)| name == source).map(|(_, text)| generated(text));
            let table = table.unwrap_or_else(|| panic!("{page}: there is no page {source}"));
            let cells = |line: &str| line.replace('|', " ").split_whitespace().collect::<Vec<_>>().join(" ");
            let found: Vec<_> = table.lines().filter(|line| cells(line).contains(row)).flat_map(numbers).collect();
            let claimed = numbers(claim);
            assert!(!claimed.is_empty(), "{page}: `{claim}` has no number");
            for (value, half) in claimed {
                let there = found.iter().any(|(found, _)| (found - value).abs() <= half * (1.0 + 1e-9));
                assert!(there, "{page}: `{claim}` differs from {source}: no line with `{row}` contains {value}");
                checked += 1;
            }
        }
    }
    assert!(checked > 50, "{checked} numbers");
}

/// Claims by their command: page, metric and claimed number.
type Claims = BTreeMap<String, Vec<(String, String, String)>>;

/// Returns the claims of all pages that begin with a mark, by their command.
fn claims(mark: &str) -> Claims {
    let mut claims = Claims::new();
    for (page, text) in pages() {
        for marked in text.split(mark).skip(1) {
            let parts = marked.split_once(" -->").and_then(|(source, rest)| {
                let (command, metric) = source.rsplit_once(' ')?;
                Some((command.to_owned(), metric.to_owned(), rest.split_once("<!-- /value -->")?.0.to_owned()))
            });
            let (command, metric, claim) = parts.unwrap_or_else(|| panic!("{page}: incomplete mark `{marked:.60}`"));
            claims.entry(command).or_default().push((page.clone(), metric, claim));
        }
    }
    claims
}

/// Returns a number of the JSON of a command: a metric by its name, or a path such as
/// `.lock[0].median_ms`.
fn looked_up(json: &Value, metric: &str) -> Option<f64> {
    let Some(place) = metric.strip_prefix('.') else {
        return json.get("metrics").unwrap_or(json).get(metric)?.as_f64();
    };
    let mut parts = place.split(['.', '[', ']']).filter(|part| !part.is_empty());
    let found = parts.try_fold(json, |at, part| match part.parse::<usize>() {
        Ok(index) => at.get(index),
        Err(_) => at.get(part),
    });
    found?.as_f64()
}

/// Returns the claims that differ from the output of their command. Units may have prefixes, and
/// ratios may be percentages.
fn wrong_claims(at: usize, command: &str, claims: &[(String, String, String)]) -> Vec<String> {
    let folder = Folder::new(&format!("values-{at}"));
    folder.measured();
    folder.scenes();
    if command.contains("rig") {
        folder.twins();
    }
    let mut arguments = shlex::split(command).unwrap_or_else(|| panic!("{command}"));
    arguments.extend(["--format".into(), "json".into()]);
    if arguments[0] == "run" {
        arguments.push("--no-report".into());
    }
    let (code, output, errors) = folder.output(&arguments);
    // A client of a board prints one line of JSON for each answer.
    let json = serde_json::from_str(&output).or_else(|_| serde_json::from_str(output.lines().last().unwrap_or_default()));
    let Ok(json) = json.map_err(|_| ()).and_then(|json: Value| if code == 0 || code == 4 { Ok(json) } else { Err(()) }) else {
        return vec![format!("{}: `sim-host {command}` ends with {code}: {errors}", claims[0].0)];
    };
    let mut wrong = Vec::new();
    for (page, metric, claim) in claims {
        let Some(found) = looked_up(&json, metric) else {
            wrong.push(format!("{page}: `sim-host {command}` has no `{metric}`"));
            continue;
        };
        let claimed = numbers(claim);
        let is_it = |&(value, half): &(f64, f64)| {
            [0, 2, -3, -6, -9, -12, 3, 6, 9, 12]
                .iter()
                // A zero would be any number with another prefix.
                .filter(|power| value != 0.0 || **power == 0)
                .any(|&power| (found.abs() * 10f64.powi(power) - value).abs() <= half * (1.0 + 1e-9))
        };
        if claimed.is_empty() || !claimed.iter().all(is_it) {
            wrong.push(format!("{page}: `{claim}`, but `sim-host {command}` has {metric} = {found}"));
        }
    }
    wrong
}

fn check_values(mark: &str) {
    let claims: Vec<_> = claims(mark).into_iter().collect();
    let wrong: Vec<String> =
        claims.par_iter().enumerate().flat_map_iter(|(at, (command, claims))| wrong_claims(at, command, claims)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn values_are_those_of_their_command() {
    check_values("<!-- value: ");
}

#[test]
#[ignore = "takes minutes"]
fn long_values_are_those_of_their_command() {
    check_values("<!-- long value: ");
}

/// Checks that each number with a unit in README and user pages has a mark or is code.
#[test]
fn every_result_has_a_mark() {
    let mut unmarked = Vec::new();
    let is_checked = |name: &str| !name.contains('/') && !REFERENCE_PAGES.contains(&name.trim_end_matches(".md"));
    for (page, text) in pages().iter().filter(|(name, _)| is_checked(name)) {
        let mut rest = text.as_str();
        let mut prose = String::new();
        // Marked numbers and generated blocks are compared elsewhere.
        while let Some((before, after)) = rest.split_once("<!-- ") {
            prose.push_str(before);
            let (mark, after) = after.split_once("-->").unwrap_or((after, ""));
            let end = if mark.contains("value: ") {
                "<!-- /value -->"
            } else if mark.starts_with("from: ") {
                "<!-- /from -->"
            } else if mark.starts_with("begin: ") {
                "<!-- end -->"
            } else {
                "" // a comment
            };
            if mark.starts_with("given") {
                prose.push_str("<!-- given");
            }
            rest = after.split_once(end).map_or(after, |(_, after)| after);
        }
        prose.push_str(rest);
        for line in prose.lines().filter(|line| !line.starts_with("    ") && !line.contains("<!-- given")) {
            let plain: String = line.split('`').step_by(2).collect::<Vec<_>>().join(" ");
            let has_unit = |word: &[&str]| {
                let number = word[0].trim_matches(|c: char| "(,;:*".contains(c));
                let unit = word[1].trim_end_matches(|c: char| !c.is_alphanumeric() && c != '%');
                number.starts_with(|first: char| first.is_ascii_digit()) && RESULT_UNITS.contains(&unit)
            };
            let words: Vec<&str> = plain.split_whitespace().collect();
            if let Some(pair) = words.windows(2).find(|pair| has_unit(pair)) {
                unmarked.push(format!("{page}: `{} {}` has no mark: {line:.100}", pair[0], pair[1]));
            }
        }
    }
    assert!(unmarked.is_empty(), "{}", unmarked.join("\n"));
}

/// Reference pages, whose numbers are mostly ranges, defaults and limits. They are not checked.
const REFERENCE_PAGES: [&str; 7] = ["board", "command-line", "faults", "glossary", "metrics-and-files", "scene-keys", "scenes"];

/// Units of results: a number with one of them is a result, unless it is marked or in code.
const RESULT_UNITS: [&str; 7] = ["ms", "us", "Hz", "%", "instructions", "cycles", "runs"];
