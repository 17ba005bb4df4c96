//! One text laid over another: a scene over its base, and `--set key=value` over a scene.

use crate::diagnostic::{Place, Problem};
use crate::exclusive::{EXCLUSIVE, LAYERED};
use crate::nearest::short;
use crate::schema::{Schema, is_index, join, without_indices};
use crate::tree::{Entry, Node, Origin, Table, Value};

/// Parses one `--set` argument, `key=value`. A value that is no TOML is taken as a string, so that names need no quotes in a
/// shell; brackets and quotes show that TOML was meant.
pub(crate) fn parse_set(text: &str, origin: Origin) -> Result<Node, Problem> {
    let example = "for example `--set controller.drive.frequency_hz=40e3`";
    let everything = || origin.place(0..text.len());
    let Some((key, value)) = text.split_once('=').filter(|(key, _)| !key.trim().is_empty()) else {
        return Err(Problem::new(everything(), "a change is written `key=value`", "lacks its key or its `=`").help(example));
    };
    let no_key = || {
        let message = format!("`{}` is no key of a scene", short(key.trim()));
        Problem::new(origin.place(0..key.len()), message, "names of tables and key, with points between").help(example)
    };
    if value.trim().is_empty() {
        return Err(Problem::new(everything(), format!("no value for `{}`", key.trim()), "nothing after `=`").help(example));
    }
    let error = match Node::parse(text, origin) {
        Ok(node) if node.table().is_some_and(|table| !table.is_empty()) => return Ok(node),
        Ok(_) => return Err(no_key()),
        Err(error) => error,
    };
    if !value.trim_start().starts_with(['[', '{', '"', '\'']) {
        let mut node = Node::parse(&format!("{key}=0"), origin).map_err(|_| no_key())?;
        let start = text.len() - value.trim_start().len();
        let place = origin.place(start..text.trim_end().len());
        set_leaf(&mut node, &Node { place, value: Value::Text(value.trim().to_owned()) });
        return Ok(node);
    }
    Err(syntax(&error, text, origin))
}

/// A syntax error of TOML as a problem.
pub(crate) fn syntax(error: &toml::de::Error, text: &str, origin: Origin) -> Problem {
    let span = error.span().unwrap_or(0..0);
    let (message, label) = error.message().split_once(", expected ").unwrap_or((error.message(), ""));
    let label = if label.is_empty() { String::new() } else { format!("expected {label}") };
    let rest = text.get(span.start..).unwrap_or_default();
    let (message, label, help) = match message {
        "duplicate key" => (
            "this name is already taken".to_owned(),
            "second time".to_owned(),
            "a key or table is written once; of a list, each entry has its own header: `[[expect]]`",
        ),
        "string values must be quoted" if rest.is_empty() || rest.starts_with(['\r', '\n', '#']) => {
            ("the value is missing".to_owned(), "expected a value".to_owned(), "")
        }
        "string values must be quoted" => (message.to_owned(), "neither a number nor in quotes".to_owned(), ""),
        "unexpected key or value" if rest.starts_with(',') => {
            (message.to_owned(), "expected the end of the line".to_owned(), "decimals have a point: 0.5")
        }
        "invalid unquoted key" => (
            message.to_owned(),
            "not a letter from a to z, digit, `_` or `-`".to_owned(),
            "a key with anything else needs quotes",
        ),
        "cannot recurse further; max recursion depth met" | "recursion limit" => {
            ("nested too deeply".to_owned(), String::new(), "")
        }
        _ => (message.to_owned(), label, ""),
    };
    let problem = Problem::new(origin.place(span), message, label);
    if help.is_empty() { problem } else { problem.help(help) }
}

/// Replaces the only value in nested tables.
fn set_leaf(node: &mut Node, leaf: &Node) {
    match &mut node.value {
        Value::Table(table) => table.values_mut().for_each(|entry| set_leaf(&mut entry.node, leaf)),
        _ => *node = leaf.clone(),
    }
}

/// Lays `over` on `under`: tables are merged, everything else is replaced. In a list of tables, keys that are numbers count its
/// entries. A key that excludes others (see [`EXCLUSIVE`]) replaces them. A number that may be absent is so with `none`.
pub(crate) fn overlay(under: &mut Node, over: Node, path: &str, problems: &mut Vec<Problem>) {
    match (&mut under.value, over.value) {
        (Value::Table(below), Value::Table(above)) => {
            give_way(below, &above, path);
            for (name, entry) in above {
                let path = join(path, &name);
                if is_none(&path, &entry.node.value) {
                    below.remove(&name);
                    continue;
                }
                match below.get_mut(&name) {
                    Some(old) => overlay(&mut old.node, entry.node, &path, problems),
                    None => {
                        let mut node = Node { place: entry.node.place.clone(), value: empty_like(&entry.node.value) };
                        overlay(&mut node, entry.node, &path, problems);
                        below.insert(name, Entry { key: entry.key, node });
                    }
                }
            }
        }
        (Value::List(below), Value::Table(above)) if counts_entries(&above) => {
            for (index, entry) in in_order(above) {
                put(below, index, entry, path, problems);
            }
        }
        (_, value) => *under = Node { place: over.place, value },
    }
}

/// Whether a value says that a number is absent that may be so.
fn is_none(path: &str, value: &Value) -> bool {
    let may_be = || Schema::root().at(path).is_some_and(|schema| schema.is_number() && schema.is_optional());
    matches!(value, Value::Text(text) if text == "none") && may_be()
}

fn put(list: &mut Vec<Node>, index: usize, entry: Entry, path: &str, problems: &mut Vec<Problem>) {
    let length = list.len();
    match list.get_mut(index) {
        Some(old) => overlay(old, entry.node, &join(path, &index.to_string()), problems),
        None if index == length => list.push(entry.node),
        None => {
            let entries = if length == 1 { "entry" } else { "entries" };
            let message = format!("`{path}` has {length} {entries}, counted from 0");
            let problem = Problem::new(entry.key, message, format!("there is no number {index}"));
            problems.push(problem.help(format!("`{path}.{length}` would add one")));
        }
    }
}

fn counts_entries(table: &Table) -> bool {
    !table.is_empty() && table.keys().all(|name| is_index(name))
}

/// As text, 10 comes before 2.
fn in_order(table: Table) -> Vec<(usize, Entry)> {
    let mut entries: Vec<_> = table.into_iter().map(|(name, entry)| (name.parse().unwrap_or(usize::MAX), entry)).collect();
    entries.sort_by_key(|(index, _)| *index);
    entries
}

/// What to lay a value on where there is nothing yet.
fn empty_like(value: &Value) -> Value {
    match value {
        Value::Table(table) if counts_entries(table) => Value::List(Vec::new()),
        _ => Value::Table(Table::new()),
    }
}

/// Removes the keys that those of `above` exclude. Of two in the same text, neither gives way: that is for the rules to tell.
fn give_way(below: &mut Table, above: &Table, path: &str) {
    let path = without_indices(path);
    for group in EXCLUSIVE.iter().chain(LAYERED).filter(|group| group.table == path) {
        for chosen in group.alternatives {
            let Some(source) = chosen.keys.iter().find_map(|key| above.get(*key)).map(|entry| entry.key.source) else { continue };
            let others = group.alternatives.iter().filter(|other| other.keys != chosen.keys).flat_map(|other| other.keys);
            for key in others {
                if below.get(*key).is_some_and(|entry: &Entry| entry.key.source != source) {
                    below.remove(*key);
                }
            }
        }
    }
}

/// The `--set` arguments as one source, a line each, and where each begins.
pub(crate) fn joined(sets: &[String]) -> (String, Vec<usize>) {
    let mut text = String::new();
    let starts = sets.iter().map(|set| {
        if !text.is_empty() {
            text.push('\n');
        }
        let start = text.len();
        text += set;
        start
    });
    let starts = starts.collect();
    (text, starts)
}

/// Gives every place in a tree the same place: for text inside a string, whose own bytes are no place of the file.
pub(crate) fn put_all_at(node: &mut Node, place: &Place) {
    node.place = place.clone();
    match &mut node.value {
        Value::List(list) => list.iter_mut().for_each(|node| put_all_at(node, place)),
        Value::Table(table) => table.values_mut().for_each(|entry| {
            entry.key = place.clone();
            put_all_at(&mut entry.node, place);
        }),
        _ => {}
    }
}
