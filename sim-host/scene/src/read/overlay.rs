//! Merging of texts: a scene over its base, and `--set key=value` over a scene.

use crate::diagnostic::{Place, Problem};
use crate::exclusive::{EXCLUSIVE, OVERLAY_EXCLUSIVE};
use crate::nearest::short;
use crate::schema::{Kind, Schema, is_index, join, without_indices};
use crate::tree::{Entry, Node, Origin, Table, Value};

/// Parses one `--set` argument, `key=value`. A value that is not TOML is taken as a string, so that
/// names need no quotes in a shell. A value that begins with a bracket or a quote must be TOML.
pub(crate) fn parse_set(text: &str, origin: Origin) -> Result<Node, Problem> {
    let example = "for example `--set controller.drive.frequency_hz=40e3`";
    let everything = || origin.place(0..text.len());
    let Some((key, value)) = text.split_once('=').filter(|(key, _)| !key.trim().is_empty()) else {
        return Err(
            Problem::new(everything(), "a change has the form `key=value`", "the key or the `=` is missing").help(example)
        );
    };
    let no_key = || {
        let message = format!("`{}` is not a key of a scene", short(key.trim()));
        Problem::new(origin.place(0..key.len()), message, "expected names of tables and key, separated by dots").help(example)
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

/// Converts a TOML syntax error to a problem.
pub(crate) fn syntax(error: &toml::de::Error, text: &str, origin: Origin) -> Problem {
    let span = error.span().unwrap_or(0..0);
    let (message, label) = error.message().split_once(", expected ").unwrap_or((error.message(), ""));
    let label = if label.is_empty() { String::new() } else { format!("expected {label}") };
    let rest = text.get(span.start..).unwrap_or_default();
    let (message, label, help) = match message {
        "duplicate key" => (
            "this name is already used".to_owned(),
            "second occurrence".to_owned(),
            "a key or table may appear only once; in a list, each entry has its own header: `[[expect]]`",
        ),
        "string values must be quoted" if rest.is_empty() || rest.starts_with(['\r', '\n', '#']) => {
            ("the value is missing".to_owned(), "expected a value".to_owned(), "")
        }
        "string values must be quoted" => (message.to_owned(), "neither a number nor in quotes".to_owned(), ""),
        "unexpected key or value" if rest.starts_with(',') => {
            (message.to_owned(), "expected the end of the line".to_owned(), "write decimals with a point: 0.5")
        }
        "invalid unquoted key" => (
            message.to_owned(),
            "not a letter from a to z, digit, `_` or `-`".to_owned(),
            "a key with other characters needs quotes",
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

/// Merges `over` into `under`: tables are merged, everything else is replaced. In a list of tables,
/// numeric keys are indices. A key that excludes others (see [`EXCLUSIVE`]) replaces them. The
/// value `none` removes an optional number, and `false` a table or list of the scene.
pub(crate) fn overlay(under: &mut Node, over: Node, path: &str, problems: &mut Vec<Problem>) {
    match (&mut under.value, over.value) {
        // A distribution is replaced as a whole, like the number that it describes.
        (Value::Table(below), Value::Table(above)) if !is_distribution(path) => {
            remove_excluded(below, &above, path);
            // The states of a law belong to its force.
            if path == "contact.expression" && ["mu", "force"].iter().all(|key| above.contains_key(*key)) {
                below.clear();
            }
            for (name, entry) in above {
                let path = join(path, &name);
                if is_none(&path, &entry.node.value) || is_removed(&path, &entry.node.value) {
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
        (Value::List(below), Value::Table(above)) if is_indexed(&above) => {
            for (index, entry) in in_order(above) {
                put_entry(below, index, entry, path, problems);
            }
        }
        (_, value) => *under = Node { place: over.place, value },
    }
}

/// Returns `true` if a table at this path is the distribution of a number.
fn is_distribution(path: &str) -> bool {
    Schema::root().at(path).is_some_and(Schema::is_number)
}

/// Returns `true` if the value removes an optional number.
fn is_none(path: &str, value: &Value) -> bool {
    let may_be = || Schema::root().at(path).is_some_and(|schema| schema.is_number() && schema.is_optional());
    matches!(value, Value::Text(text) if text == "none") && may_be()
}

/// Returns `true` if the value removes a table or list of the scene, for example `grid = false`.
fn is_removed(path: &str, value: &Value) -> bool {
    let may_be = || Schema::root().at(path).is_some_and(|schema| matches!(schema.kind(), Kind::Table | Kind::List));
    matches!(value, Value::Flag(false)) && may_be()
}

fn put_entry(list: &mut Vec<Node>, index: usize, entry: Entry, path: &str, problems: &mut Vec<Problem>) {
    let length = list.len();
    match list.get_mut(index) {
        Some(old) => overlay(old, entry.node, &join(path, &index.to_string()), problems),
        None if index == length => list.push(entry.node),
        None => {
            let entries = if length == 1 { "entry" } else { "entries" };
            let message = format!("`{path}` has {length} {entries}, counted from 0");
            let problem = Problem::new(entry.key, message, format!("there is no entry {index}"));
            problems.push(problem.help(format!("`{path}.{length}` adds one")));
        }
    }
}

fn is_indexed(table: &Table) -> bool {
    !table.is_empty() && table.keys().all(|name| is_index(name))
}

/// Sorts entries by number; as text, 10 would come before 2.
fn in_order(table: Table) -> Vec<(usize, Entry)> {
    let mut entries: Vec<_> = table.into_iter().map(|(name, entry)| (name.parse().unwrap_or(usize::MAX), entry)).collect();
    entries.sort_by_key(|(index, _)| *index);
    entries
}

/// Returns an empty container for a value whose key does not exist yet.
fn empty_like(value: &Value) -> Value {
    match value {
        Value::Table(table) if is_indexed(table) => Value::List(Vec::new()),
        _ => Value::Table(Table::new()),
    }
}

/// Removes the keys that those of `above` exclude. Two keys of the same text are both kept; the
/// rules report them.
fn remove_excluded(below: &mut Table, above: &Table, path: &str) {
    let path = without_indices(path);
    for group in EXCLUSIVE.iter().chain(OVERLAY_EXCLUSIVE).filter(|group| group.table == path) {
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

/// Joins the `--set` arguments to one source, one per line, and returns the offset of each.
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

/// Sets all places of a tree to one place. Used for text inside a string, whose bytes have no place
/// in the file.
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
