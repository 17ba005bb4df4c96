//! Names of the places of a scene in messages.

use crate::nearest::{short, shown};
use crate::schema::{Kind, Schema, last_name, unit_of, without_indices};
use crate::suite::file;
use crate::tree::Entry;

/// Returns the header of a table.
pub(crate) fn header(path: &str) -> String {
    let table = without_indices(path);
    let known = Schema::root().at(&table).or_else(|| file::root().at(&table));
    let list = known.is_some_and(|schema| schema.kind() == Kind::List);
    match table.as_str() {
        "" => "the top level".to_owned(),
        _ if list => format!("[[{table}]]"),
        _ => format!("[{table}]"),
    }
}

/// Returns the position of a table in a scene, as an adverbial.
pub(crate) fn within(path: &str) -> String {
    if path.is_empty() { "at the top level".to_owned() } else { format!("in {}", header(path)) }
}

/// Returns the key of an entry for messages, shortened.
pub(crate) fn named(name: &str, entry: &Entry) -> String {
    let what = if entry.node.table().is_some() { "table" } else { "key" };
    format!("{what} `{}`", short(name))
}

/// Returns the unit of a key.
pub(crate) fn unit(path: &str) -> Option<String> {
    unit_of(last_name(path))
}

/// Returns a number with the unit of its key.
pub(crate) fn quantity(number: f64, path: &str) -> String {
    format!("{}{}", shown(number), unit(path).map_or(String::new(), |unit| format!(" {unit}")))
}

/// Describes the range of a number, with the unit of its key.
pub(crate) fn range((least, most): (Option<f64>, Option<f64>), path: &str) -> String {
    match (least, most) {
        (Some(least), Some(most)) => format!("from {} to {}", shown(least), quantity(most, path)),
        (Some(least), None) => format!("at least {}", quantity(least, path)),
        (None, Some(most)) => format!("at most {}", quantity(most, path)),
        (None, None) => "any number".to_owned(),
    }
}

/// Rounds the end of a range to six digits, so that it is still allowed; `inward` is the sign of
/// the direction into the range.
pub(crate) fn bound(end: f64, inward: f64, allowed: impl Fn(f64) -> bool) -> f64 {
    let six_digits = |number: f64| format!("{number:.5e}").parse().unwrap_or(number);
    let near = six_digits(end);
    if allowed(near) || near == 0.0 {
        return near;
    }
    let last_digit = 10f64.powi(near.abs().log10().floor() as i32 - 5);
    six_digits(near + inward * last_digit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_rounded_inward() {
        assert_eq!(bound(2000.0 / 3.0, -1.0, |x| x <= 2000.0 / 3.0), 666.666);
        assert_eq!(bound(2000.0 / 3.0, 1.0, |x| x >= 2000.0 / 3.0), 666.667);
        assert_eq!(bound(-0.1 - 0.2, 1.0, |x| x >= -0.1 - 0.2), -0.3);
        assert_eq!(bound(0.2, -1.0, |x| x < 0.2), 0.199999);
        assert_eq!(bound(0.0, -1.0, |_| false), 0.0);
    }
}
