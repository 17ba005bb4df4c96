//! Distributions instead of numbers. Each is replaced by its central value and an entry of
//! `[[vary]]`, before the scene is checked.
//!
//! | in the scene | distribution | central value |
//! |---|---|---|
//! | `{ value = x, sd = s }` | normal | `x` |
//! | `{ low = a, high = b }` | uniform | `(a + b) / 2` |
//! | `{ log_low = a, log_high = b }` | log-uniform | `sqrt(a b)` |
//! | `{ samples = [x1, x2] }` | one of the numbers | their median |
//! | `{ samples = "file.csv", column = "mu" }` | a row of a table, the same row for all keys | their median |
//!
//! A contact study or a design with a distribution runs 256 times, or more often if its interval
//! requires it, unless it has `runs`. A driven
//! scene, whose runs take longer, needs `runs`.

use std::collections::BTreeSet;
use std::path::PathBuf;

use crate::diagnostic::{Place, Problem, Source};
use crate::nearest::{listed, shown};
use crate::profile::column::{About, Measured, Refusal, text_of};
use crate::profile::resolve::path_of;
use crate::schema::{Schema, join};
use crate::tree::{Entry, Node, Table, Value};
use columns::unit as units;

/// Number of runs of a contact study with a distribution.
const RUNS: i64 = 256;
/// Forms of a distribution.
const FORMS: &str = "a distribution is `{ value = …, sd = … }`, `{ low = …, high = … }`, `{ log_low = …, log_high = … }`, \
                     `{ samples = [ … ] }` or `{ samples = \"file.csv\", column = \"…\" }`; a change replaces all of it";

/// A table where the scene needs a number, with the path of the number.
type Found = (String, Schema, Node);

/// Keys of an entry of `[[vary]]`.
type Keys = Vec<(&'static str, Value)>;

/// Replaces the distributions of a scene. Returns the files that they are read from, and `true` if
/// the number of runs is the default.
///
/// # Errors
/// If a table at the path of a number is not a distribution.
pub(crate) fn replace(root: &mut Node, sources: &[Source]) -> Result<(Vec<PathBuf>, bool), Vec<Problem>> {
    let (mut found, mut files, mut problems) = (Vec::new(), Vec::new(), Vec::new());
    find(root, Schema::root(), "", &mut found);
    let Some(first) = found.first().map(|(_, _, node)| node.place.clone()) else { return Ok((files, false)) };
    for (path, schema, node) in found {
        match central_value(&path, &node, sources, &mut files) {
            Ok((value, keys)) => {
                let whole = schema.kind() == crate::schema::Kind::Integer;
                if let Some(number) = root.at_mut(&path) {
                    number.value = Value::Number(if whole { value.round() } else { value });
                }
                vary(root, &path, &node.place, keys);
            }
            Err(problem) => problems.push(problem),
        }
    }
    let mut is_default = false;
    if let Value::Table(table) = &mut root.value
        && ["excitation", "design"].iter().any(|kind| table.contains_key(*kind))
        && !table.contains_key("runs")
    {
        is_default = true;
        table.insert("runs".to_owned(), Entry { key: first.clone(), node: Node { place: first, value: Value::Integer(RUNS) } });
    }
    if problems.is_empty() { Ok((files, is_default)) } else { Err(problems) }
}

/// Collects the tables at the paths of numbers.
fn find(node: &Node, schema: Schema, path: &str, found: &mut Vec<Found>) {
    match &node.value {
        Value::Table(_) if schema.is_number() => found.push((path.to_owned(), schema, node.clone())),
        Value::Table(table) => {
            for (name, entry) in table {
                if let Some(schema) = schema.entry(name) {
                    find(&entry.node, schema, &join(path, name), found);
                }
            }
        }
        Value::List(list) => {
            for (index, item) in list.iter().enumerate() {
                if let Some(schema) = schema.items() {
                    find(item, schema, &join(path, &index.to_string()), found);
                }
            }
        }
        _ => {}
    }
}

/// Adds an entry of `[[vary]]`.
fn vary(root: &mut Node, path: &str, place: &Place, keys: Keys) {
    let entry = |value| Entry { key: place.clone(), node: Node { place: place.clone(), value } };
    let keys = keys.into_iter().map(|(name, value)| (name.to_owned(), entry(value)));
    let table: Table = keys.chain([("key".to_owned(), entry(Value::Text(path.to_owned())))]).collect();
    let Value::Table(tables) = &mut root.value else { return };
    let list = tables.entry("vary".to_owned()).or_insert_with(|| entry(Value::List(Vec::new())));
    if let Value::List(list) = &mut list.node.value {
        list.push(Node { place: place.clone(), value: Value::Table(table) });
    }
}

/// Returns the central value of a distribution, and its keys in `[[vary]]`.
fn central_value(path: &str, node: &Node, sources: &[Source], files: &mut Vec<PathBuf>) -> Result<(f64, Keys), Problem> {
    let table = node.table();
    let mut names: Vec<&str> = table.into_iter().flatten().map(|(name, _)| name.as_str()).collect();
    names.sort_unstable();
    let wrong = |message: String, label: &str| Problem::new(node.place.clone(), message, label).help(FORMS);
    let number = |name: &str| {
        let number = node.at(name).and_then(Node::number).filter(|number| number.is_finite());
        number.ok_or_else(|| wrong(format!("`{name}` of the distribution of `{path}` is not a number"), "must be a number"))
    };
    let empty = |low: f64, high: f64| {
        let message = format!("the distribution of `{path}` from {} to {} is empty", shown(low), shown(high));
        wrong(message, "the first number must be less than the second")
    };
    match names.as_slice() {
        ["sd", "value"] => {
            let (value, sd) = (number("value")?, number("sd")?);
            if sd <= 0.0 {
                return Err(wrong(format!("the standard deviation of `{path}` is {}", shown(sd)), "`sd` must be above zero"));
            }
            Ok((value, vec![("sd", Value::Number(sd))]))
        }
        ["high", "low"] => {
            let (low, high) = (number("low")?, number("high")?);
            if low >= high {
                return Err(empty(low, high));
            }
            Ok((0.5 * low + 0.5 * high, vec![("from", Value::Number(low)), ("to", Value::Number(high))]))
        }
        ["log_high", "log_low"] => {
            let (low, high) = (number("log_low")?, number("log_high")?);
            if low <= 0.0 {
                let message = format!("the distribution of `{path}` is logarithmic, but begins at {}", shown(low));
                return Err(wrong(message, "`log_low` must be above zero"));
            }
            if low >= high {
                return Err(empty(low, high));
            }
            let keys = vec![("from", Value::Number(low)), ("to", Value::Number(high)), ("log", Value::Flag(true))];
            Ok((libm::sqrt(low) * libm::sqrt(high), keys))
        }
        ["samples"] | ["column", "samples"] => {
            let (samples, set) = samples(path, node, sources, files)?;
            let Some(median) = median(&samples) else {
                return Err(wrong(format!("the distribution of `{path}` has no samples"), "needs at least one number"));
            };
            let place = &node.place;
            let list = samples.into_iter().map(|value| Node { place: place.clone(), value: Value::Number(value) }).collect();
            let set = set.map(|set| ("set", Value::Text(set)));
            Ok((median, [("samples", Value::List(list))].into_iter().chain(set).collect()))
        }
        [] => Err(wrong(format!("`{path}` is an empty table"), "expected a number or a distribution")),
        names => {
            let message = format!("`{path}` with {} is not a distribution", listed(names.iter().copied(), "and"));
            Err(wrong(message, "neither a number nor a distribution"))
        }
    }
}

/// Returns the samples, from the scene or from a column of a file, and the name of the file.
fn samples(path: &str, node: &Node, sources: &[Source], files: &mut Vec<PathBuf>) -> Result<(Vec<f64>, Option<String>), Problem> {
    let wrong = |message: String, label: &str| Problem::new(node.place.clone(), message, label).help(FORMS);
    let given = node.at("samples");
    if let Some(numbers) = given.map(Node::list).filter(|_| matches!(given.map(|node| &node.value), Some(Value::List(_)))) {
        if node.at("column").is_some() {
            return Err(wrong(format!("`column` of `{path}` has no file"), "`samples` are numbers"));
        }
        let numbers: Option<Vec<f64>> = numbers.iter().map(|node| node.number().filter(|number| number.is_finite())).collect();
        let numbers = numbers.ok_or_else(|| wrong(format!("`samples` of `{path}` are not numbers"), "expected numbers"))?;
        return Ok((numbers, None));
    }
    let Some((file, name)) = given.and_then(|file| Some((file, file.text()?))) else {
        return Err(wrong(format!("`samples` of `{path}` are neither numbers nor a file"), "expected a list or a file name"));
    };
    let refused = |refusal: Refusal| {
        let at = match refusal.about {
            About::Column => node.at("column").map_or(node.place.clone(), |column| column.place.clone()),
            _ => file.place.clone(),
        };
        Problem { at, message: refusal.message, label: refusal.label, help: refusal.help }
    };
    let found = path_of(file, name, sources);
    let text = text_of(&found, name).map_err(refused)?;
    // A file of the same name in the folder of a base is another set.
    let others: BTreeSet<_> = files.iter().filter(|other| **other != found && other.file_name() == found.file_name()).collect();
    let set = if others.is_empty() { name.to_owned() } else { format!("{name} ({})", others.len() + 1) };
    files.push(found);
    let measured = Measured::from_text(name, text).map_err(|(refusal, _)| refused(refusal))?;
    let key = path.rsplit('.').next().unwrap_or(path);
    let column =
        node.at("column").and_then(|column| column.text().map(str::to_owned).or(column.number().map(|at| at.to_string())));
    let column = measured.only_index(column.as_deref()).map_err(refused)?;
    let column = measured.column(column, None, units::split(key).1.as_ref(), None).map_err(refused)?;
    Ok((column.values, Some(set)))
}

fn median(samples: &[f64]) -> Option<f64> {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = |of: usize| sorted.get(of / 2).copied();
    Some(0.5 * (middle(sorted.len().checked_sub(1)?)? + middle(sorted.len())?))
}
