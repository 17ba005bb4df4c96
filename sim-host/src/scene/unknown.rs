//! A key that a table does not have: what was meant by it?

use super::diagnostic::Problem;
use super::nearest::{listed, nearest, short, shown};
use super::schema::{Schema, join};
use super::tree::{Entry, Node};
use super::units;
use super::wording::{header, named, within};

/// Explains an unknown key, and says which key of the same table was probably meant.
pub(super) fn unknown(table: Schema, path: &str, name: &str, entry: &Entry) -> (Problem, Option<&'static str>) {
    if let Some((problem, meant)) = wrong_unit(table, name, entry) {
        return (problem, Some(meant));
    }
    let homes: Vec<_> = Schema::tables().into_iter().filter(|(_, table)| table.property(name).is_some()).collect();
    if let [(home, _), ..] = homes.as_slice() {
        let homes = homes.iter().map(|(path, _)| within(path)).collect::<Vec<_>>().join(" or ");
        let message = format!("{} is misplaced {}", named(name, entry), within(path));
        let problem = Problem::new(entry.key.clone(), message, format!("belongs {homes}"));
        let help = if home.is_empty() { "write it above the first table header".to_owned() } else { allowed(table, path) };
        return (problem.help(help), None);
    }
    let message = format!("unknown {} {}", named(name, entry), within(path));
    if let Some(meant) = nearest(name, table.properties().map(|(name, _)| name)).first().copied() {
        let problem = Problem::new(entry.key.clone(), message, format!("did you mean `{meant}`?"));
        return (problem.help(allowed(table, path)), Some(meant));
    }
    let elsewhere = Schema::tables().into_iter().find_map(|(path, table)| Some((path, wrong_unit(table, name, entry)?.1)));
    let label = match elsewhere {
        Some((home, meant)) => format!("did you mean `{}`?", join(&home, meant)),
        None => "not known here".to_owned(),
    };
    (Problem::new(entry.key.clone(), message, label).help(allowed(table, path)), None)
}

fn allowed(table: Schema, path: &str) -> String {
    format!("{} takes {}", header(path), listed(table.properties().map(|(name, _)| name), "and"))
}

/// A known quantity in a unit that is not the one of the key, or without any.
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
        let message = format!("`{}` lacks its unit", short(name));
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

/// The number, or the list of numbers, times a factor.
fn converted(node: &Node, factor: f64) -> Option<String> {
    let times = |node: &Node| node.number().filter(|n| n.is_finite()).map(|number| shown(number * factor));
    if node.list().is_empty() {
        return times(node);
    }
    let numbers: Option<Vec<_>> = node.list().iter().map(times).collect();
    Some(format!("[{}]", numbers?.join(", ")))
}
