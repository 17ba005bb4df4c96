//! How messages call the places of a scene.

use super::nearest::short;
use super::schema::{Kind, Schema, without_indices};
use super::tree::Entry;

/// A table as its header would be written.
pub(super) fn header(path: &str) -> String {
    let table = without_indices(path);
    let list = Schema::root().at(&table).is_some_and(|schema| schema.kind() == Kind::List);
    match table.as_str() {
        "" => "the top level".to_owned(),
        _ if list => format!("[[{table}]]"),
        _ => format!("[{table}]"),
    }
}

/// Where in a scene a table is.
pub(super) fn within(path: &str) -> String {
    if path.is_empty() { "at the top level".to_owned() } else { format!("in {}", header(path)) }
}

/// The key of an entry in messages, shortened.
pub(super) fn named(name: &str, entry: &Entry) -> String {
    let what = if entry.node.table().is_some() { "table" } else { "key" };
    format!("{what} `{}`", short(name))
}
