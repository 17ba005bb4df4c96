//! The walk through a scene, guided by the schema: it checks every key, type, range and choice, and
//! finds all problems at once.

use std::collections::BTreeSet;

use crate::diagnostic::{Place, Problem};
use crate::nearest::{listed, nearest, short, shown};
use crate::schema::{Kind, Schema, join};
use crate::tree::{Node, Value};
use crate::unknown;
use crate::wording::{header, range, unit, within};

/// Problems, and the paths of their keys.
#[derive(Clone, Debug, Default)]
pub(crate) struct Findings {
    pub(super) problems: Vec<Problem>,
    bad: BTreeSet<String>,
    /// Paths of keys and tables that are given under another name or in another table.
    meant: BTreeSet<String>,
    /// Schema of the whole file.
    root: Option<Schema>,
}

impl Findings {
    /// Adds a problem, and marks the path of its value.
    pub(crate) fn add(&mut self, path: impl Into<String>, problem: Problem) {
        self.bad.insert(path.into());
        self.problems.push(problem);
    }

    /// Marks a path that is affected by the problem of another path.
    pub(crate) fn mark(&mut self, path: impl Into<String>) {
        self.bad.insert(path.into());
    }

    /// Returns `true` if a value, its contents and the tables that contain it have no problem.
    pub(crate) fn clean(&self, path: &str) -> bool {
        !self.bad.iter().any(|bad| inside(bad, path) || inside(path, bad))
    }

    /// Returns `true` if the value itself has a problem; problems of its contents or its table do
    /// not count.
    pub(crate) fn marked(&self, path: &str) -> bool {
        self.bad.contains(path)
    }

    /// Returns `true` if a path, or a part of it, is probably given under another name. Its absence
    /// is then already reported.
    pub(crate) fn meant(&self, path: &str) -> bool {
        self.meant.iter().any(|meant| inside(meant, path) || inside(path, meant))
    }
}

/// Returns `true` if a path equals another one or is a part of it.
fn inside(part: &str, whole: &str) -> bool {
    part.strip_prefix(whole).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Checks a scene. A whole number written as `32.0` becomes an integer.
pub(crate) fn walk(root: &mut Node) -> Findings {
    walk_by(root, Schema::root())
}

/// Checks a file of another type than a scene, by its schema.
pub(crate) fn walk_by(root: &mut Node, schema: Schema) -> Findings {
    let mut findings = Findings { root: Some(schema), ..Findings::default() };
    check(root, schema, "", &mut findings);
    findings
}

fn check(node: &mut Node, schema: Schema, path: &str, findings: &mut Findings) {
    match (schema.kind(), &mut node.value) {
        (Kind::Table, Value::Table(_)) => check_table(node, schema, path, findings),
        (Kind::List, Value::List(list)) => {
            let Some(items) = schema.items() else { return };
            for (index, item) in list.iter_mut().enumerate() {
                check(item, items, &join(path, &index.to_string()), findings);
            }
            if let Some(problem) = wrong_length(node, schema, path) {
                findings.add(path, problem);
            }
        }
        (Kind::Number | Kind::Integer, Value::Integer(_) | Value::Number(_)) => {
            if let Some(problem) = wrong_number(node, schema, path) {
                findings.add(path, problem);
            } else if let (Kind::Integer, Some(number)) = (schema.kind(), node.number()) {
                node.value = match node.value {
                    Value::Number(_) => Value::Integer(number as i64),
                    _ => return,
                };
            }
        }
        (Kind::Choice, Value::Text(text)) => {
            let choices = schema.choices();
            if !choices.contains(&text.as_str()) {
                let meant = nearest(text, choices.iter().copied());
                let label = meant.first().map_or("not one of its values".to_owned(), |meant| format!("did you mean `{meant}`?"));
                let message = format!("`{path}` cannot be \"{}\"", short(text));
                let help = format!("it must be {}", listed(choices, "or"));
                findings.add(path, Problem::new(node.place.clone(), message, label).help(help));
            }
        }
        (Kind::Text, Value::Text(text)) => {
            if let Some(letter) = columns::hidden(text) {
                let message = format!("`{path}` contains the invisible character {}", letter.escape_default());
                findings.add(path, Problem::new(node.place.clone(), message, "remove this character"));
            }
        }
        (Kind::Flag, Value::Flag(_)) | (Kind::List, Value::Samples(_)) => {}
        _ => findings.add(path, wrong_type(node, schema, path)),
    }
}

fn check_table(node: &mut Node, schema: Schema, path: &str, findings: &mut Findings) {
    let place = node.place.clone();
    let Value::Table(table) = &mut node.value else { return };
    let mut unknown_table = false;
    for (name, entry) in table.iter_mut() {
        let inner = join(path, name);
        match schema.entry(name) {
            Some(schema) => check(&mut entry.node, schema, &inner, findings),
            None => {
                let (problem, meant) = unknown::unknown(findings.root.unwrap_or_else(Schema::root), schema, path, name, entry);
                unknown_table |= meant.is_empty() && entry.node.table().is_some();
                findings.meant.extend(meant);
                findings.add(inner, problem);
            }
        }
    }
    // A design has no duration.
    let is_needed = |name: &&str| *name != "duration_s" || !path.is_empty() || !table.contains_key("design");
    for name in schema.required().filter(|name| !table.contains_key(*name)).filter(is_needed) {
        let missing = join(path, name);
        // A misspelt key is already reported at its place. An unknown table is probably meant to be
        // the missing one.
        let instead = unknown_table && schema.property(name).is_some_and(|schema| schema.kind() == Kind::Table);
        if !findings.meant(&missing) && !instead {
            findings.problems.push(missing_key(schema, path, name, &place));
        }
        findings.mark(missing);
    }
}

fn missing_key(table: Schema, path: &str, name: &str, place: &Place) -> Problem {
    let inner = join(path, name);
    let Some(schema) = table.property(name) else {
        return Problem::new(place.clone(), format!("`{inner}` is missing"), "");
    };
    let meaning = schema.description().unwrap_or_default();
    if schema.kind() != Kind::Table {
        let message = format!("`{name}` is missing {}", within(path));
        return Problem::new(place.clone(), message, format!("needs `{name}`, {}", expected(schema, name))).help(meaning);
    }
    let header = header(&inner);
    let keys = listed(schema.required(), "and");
    let label = if keys.is_empty() { format!("add {header}") } else { format!("add {header} with at least {keys}") };
    Problem::new(place.clone(), format!("the table {header} is missing"), label).help(meaning)
}

fn wrong_length(node: &Node, schema: Schema, path: &str) -> Option<Problem> {
    let length = node.list().len() as u64;
    let (fewest, most) = schema.lengths();
    let label = match (fewest, most) {
        (Some(fewest), _) if length < fewest => format!("needs at least {fewest}"),
        (_, Some(most)) if length > most => format!("takes at most {most}"),
        _ => return None,
    };
    let entries = if length == 1 { "entry" } else { "entries" };
    Some(Problem::new(node.place.clone(), format!("`{path}` has {length} {entries}"), label))
}

/// Returns the problem of a number that is not finite, out of range, or not whole.
pub(crate) fn wrong_number(node: &Node, schema: Schema, path: &str) -> Option<Problem> {
    const MAX_EXACT_INTEGER: f64 = 9_007_199_254_740_992.0;
    let number = node.number()?;
    let problem = |message: String, label: String| {
        let problem = Problem::new(node.place.clone(), message, label);
        Some(match schema.description() {
            Some(meaning) => problem.help(meaning),
            None => problem,
        })
    };
    if !number.is_finite() {
        return problem(format!("`{path}` must be a finite number"), format!("expected {}", expected(schema, path)));
    }
    let (least, most) = schema.range();
    if least.is_some_and(|least| number < least) || most.is_some_and(|most| number > most) {
        return problem(format!("`{path}` is out of range"), format!("must be {}", range((least, most), path)));
    }
    let whole = matches!(node.value, Value::Integer(_)) || (number.fract() == 0.0 && number.abs() <= MAX_EXACT_INTEGER);
    if schema.kind() == Kind::Integer && !whole {
        return problem(format!("`{path}` must be a whole number"), "has a fraction, or too many digits".to_owned());
    }
    None
}

fn wrong_type(node: &Node, schema: Schema, path: &str) -> Problem {
    let message = format!("`{path}` cannot be {}", node.kind());
    let problem = Problem::new(node.place.clone(), message, format!("expected {}", expected(schema, path)));
    let items = schema.items().map(Schema::kind);
    let help = match (schema.kind(), &node.value) {
        (Kind::Table, Value::List(_)) => Some(format!("there is only one: write `[{path}]`, in single brackets")),
        (Kind::Table, _) => Some(format!("write `{}` on a line of its own, and its keys below", header(path))),
        (Kind::List, Value::Table(_)) if items == Some(Kind::Table) => {
            Some(format!("there may be several: write `[[{path}]]`, in double brackets"))
        }
        (Kind::List, Value::Integer(_) | Value::Number(_)) if items == Some(Kind::Number) => {
            Some(format!("a single value also needs brackets: `[{}]`", shown(node.number().unwrap_or_default())))
        }
        (Kind::List, Value::Text(text)) if items != Some(Kind::Table) => {
            Some(format!("a single value also needs brackets: `[\"{}\"]`", short(text)))
        }
        (Kind::Number | Kind::Integer, Value::Text(text)) if text.trim().parse::<f64>().is_ok_and(f64::is_finite) => {
            Some(format!("without the quotes: {}", text.trim()))
        }
        (Kind::Number | Kind::Integer, Value::Text(_)) => {
            unit(path).map(|unit| format!("a number only; the key's name gives its unit, {unit}"))
        }
        (Kind::Text | Kind::Choice, Value::Integer(_) | Value::Number(_)) => Some("a string is written in quotes".to_owned()),
        _ => None,
    };
    match help.as_deref().or(schema.description()) {
        Some(help) => problem.help(help),
        None => problem,
    }
}

/// Returns the expected type in words.
fn expected(schema: Schema, path: &str) -> String {
    let with_unit = |what: &str| unit(path).map_or(what.to_owned(), |unit| format!("{what} in {unit}"));
    match schema.kind() {
        Kind::Table => "a table".to_owned(),
        Kind::List => match schema.items().map(Schema::kind) {
            Some(Kind::Table) => "a list of tables".to_owned(),
            Some(Kind::Number | Kind::Integer) => with_unit("a list of numbers"),
            _ => "a list of strings".to_owned(),
        },
        Kind::Number => with_unit("a number"),
        Kind::Integer => with_unit("a whole number"),
        Kind::Text => "a string".to_owned(),
        Kind::Flag => "true or false".to_owned(),
        Kind::Choice if schema.choices().len() <= 8 => listed(schema.choices(), "or"),
        Kind::Choice => "one of several strings".to_owned(),
    }
}
