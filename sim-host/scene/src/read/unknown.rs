//! Explanation of unknown keys: search for the key that was meant.

use crate::diagnostic::Problem;
use crate::nearest::{listed, nearest, short, shown};
use crate::schema::{Schema, join};
use crate::tree::{Entry, Node};
use crate::wording::{header, named, within};
use columns::unit as units;

/// Explains an unknown key, and returns the paths of the keys that were probably meant.
pub(crate) fn unknown(root: Schema, table: Schema, path: &str, name: &str, entry: &Entry) -> (Problem, Vec<String>) {
    if let Some((problem, meant)) = wrong_unit(table, name, entry) {
        return (problem, vec![join(path, meant)]);
    }
    let homes: Vec<_> = root.tables_within().into_iter().filter(|(_, table)| table.property(name).is_some()).collect();
    if let [(home, _), ..] = homes.as_slice() {
        let places = homes.iter().map(|(path, _)| within(path)).collect::<Vec<_>>().join(" or ");
        let message = format!("{} is misplaced {}", named(name, entry), within(path));
        let problem = Problem::new(entry.key.clone(), message, format!("belongs {places}"));
        let help = if home.is_empty() { "write it above the first table header".to_owned() } else { allowed(table, path) };
        return (problem.help(help), homes.iter().map(|(home, _)| join(home, name)).collect());
    }
    let message = format!("unknown {} {}", named(name, entry), within(path));
    if let Some(meant) = nearest(name, table.properties().map(|(name, _)| name)).first().copied() {
        let problem = Problem::new(entry.key.clone(), message, format!("did you mean `{meant}`?"));
        return (problem.help(allowed(table, path)), vec![join(path, meant)]);
    }
    let elsewhere = root.tables_within().into_iter().find_map(|(path, table)| Some((path, wrong_unit(table, name, entry)?.1)));
    let meant: Vec<_> = elsewhere.into_iter().map(|(home, key)| join(&home, key)).collect();
    let label = meant.first().map_or("not known here".to_owned(), |meant| format!("did you mean `{meant}`?"));
    (Problem::new(entry.key.clone(), message, label).help(allowed(table, path)), meant)
}

fn allowed(table: Schema, path: &str) -> String {
    format!("{} has the keys {}", header(path), listed(table.properties().map(|(name, _)| name), "and"))
}

/// Explains a known quantity whose unit is missing or wrong.
fn wrong_unit(table: Schema, name: &str, entry: &Entry) -> Option<(Problem, &'static str)> {
    let lower = name.to_lowercase();
    let (quantity, given) = units::split(&lower);
    let keys: Vec<_> = table.properties().filter_map(|(key, _)| Some((key, units::split(key).0, units::split(key).1?))).collect();
    let same = keys.iter().find(|(_, other, _)| *other == quantity);
    let alike = || {
        let candidates = keys.iter().filter(|(.., unit)| given.as_ref().is_some_and(|given| given.measures_like(unit)));
        let nearest = nearest(quantity, candidates.clone().map(|(_, other, _)| *other)).first().copied();
        candidates.clone().find(|(_, other, _)| Some(*other) == nearest)
    };
    let (key, _, unit) = same.or_else(alike).filter(|(key, ..)| *key != lower)?;
    let Some(given) = given else {
        let message = format!("the unit of `{}` is missing", short(name));
        return Some((Problem::new(entry.key.clone(), message, format!("give it in {}: `{key}`", unit.symbol)), key));
    };
    if given == *unit {
        return None;
    }
    let message = format!("`{}` is in {}, but {} is expected here", short(name), given.symbol, unit.symbol);
    let problem = Problem::new(entry.key.clone(), message, format!("give it in {}: `{key}`", unit.symbol));
    let converted = given.factor_to(unit).and_then(|factor| converted(&entry.node, factor));
    Some((
        match converted {
            Some(value) => problem.help(format!("write `{key} = {value}`")),
            None => problem,
        },
        key,
    ))
}

/// Returns the number, or the list of numbers, multiplied by a factor.
fn converted(node: &Node, factor: f64) -> Option<String> {
    let times = |node: &Node| node.number().filter(|n| n.is_finite()).map(|number| shown(number * factor));
    if node.list().is_empty() {
        return times(node);
    }
    let numbers: Option<Vec<_>> = node.list().iter().map(times).collect();
    Some(format!("[{}]", numbers?.join(", ")))
}
