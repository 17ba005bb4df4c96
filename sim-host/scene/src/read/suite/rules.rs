//! Rules that the schema of a suite cannot express: names must refer to existing entries.

use super::{DERIVED, STEPS};
use crate::diagnostic::Problem;
use crate::metrics;
use crate::nearest::{listed, nearest, short};
use crate::tree::Node;
use crate::walk::Findings;

pub(super) fn check(root: &Node, found: &mut Findings) {
    for list in ["case", "preset"] {
        check_unique(root, list, found);
    }
    let names = |list: &str, key: &str| strings(root, &[&format!("{list}.*.{key}")]);
    let (presets, groups) = (names("preset", "name"), names("case", "group"));
    let mut cases = names("case", "name");
    for (case, (_, name)) in names("case", "name").into_iter().enumerate() {
        let each = strings(root, &[&format!("case.{case}.each.*")]);
        cases.extend(each.into_iter().map(|(path, preset)| (path, format!("{name}, {preset}"))));
    }
    known(root, &["case.*.use.*", "case.*.each.*"], "preset", &presets, found);
    known(root, &["target.*.groups.*", "table.*.groups.*"], "group", &groups, found);
    known(root, &["target.*.cases.*", "quick.cases.*"], "case", &cases, found);
    for (path, name) in strings(root, &["target.*.metric", "table.*.column.*.metrics.*"]) {
        let derived = || DERIVED.iter().map(|(name, _)| *name).chain([STEPS]);
        if !metrics::is_known(&name) && !derived().any(|known| known == name) {
            unknown(root, &path, "metric", &name, metrics::names().chain(derived()), found);
        }
    }
    for (index, target) in root.at("target").map_or(&[][..], Node::list).iter().enumerate() {
        let has = |key: &str| target.at(key).is_some();
        let ways = [has("min") || has("max"), has("value"), has("one_of")];
        if ways.iter().filter(|way| **way).count() != 1 || has("value") != has("tolerance") {
            let at = target.entry("metric").map_or_else(|| target.place.clone(), |entry| entry.key.clone());
            let problem = Problem::new(at, "the target has no limit, or more than one", "give one limit");
            found.add(format!("target.{index}"), problem.help("`min` and/or `max`, or `value` and `tolerance`, or `one_of`"));
        }
    }
}

/// Returns the strings at these paths, in which `*` is every entry of a list.
fn strings(root: &Node, paths: &[&str]) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for path in paths {
        match path.split_once(".*") {
            Some((list, rest)) => {
                for index in 0..root.at(list).map_or(0, |node| node.list().len()) {
                    found.extend(strings(root, &[&format!("{list}.{index}{rest}")]));
                }
            }
            None => found.extend(root.at(path).and_then(Node::text).map(|text| ((*path).to_owned(), text.to_owned()))),
        }
    }
    found
}

fn known(root: &Node, paths: &[&str], what: &str, names: &[(String, String)], found: &mut Findings) {
    for (path, name) in strings(root, paths) {
        if !names.iter().any(|(_, known)| *known == name) {
            unknown(root, &path, what, &name, names.iter().map(|(_, name)| name.as_str()), found);
        }
    }
}

fn unknown<'a>(
    root: &Node,
    path: &str,
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
    found: &mut Findings,
) {
    let at = root.at(path).map_or_else(|| root.place.clone(), |node| node.place.clone());
    let label = match nearest(name, known.clone()).first() {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => format!("not a {what} of this suite"),
    };
    let mut names: Vec<&str> = known.collect();
    names.sort_unstable();
    names.dedup();
    let problem = Problem::new(at, format!("there is no {what} `{}`", short(name)), label);
    let help =
        if names.is_empty() { format!("this suite has no {what}") } else { format!("this suite has {}", listed(names, "and")) };
    found.add(path, problem.help(help));
}

fn check_unique(root: &Node, list: &str, found: &mut Findings) {
    let names = strings(root, &[&format!("{list}.*.name")]);
    for (index, (path, name)) in names.iter().enumerate() {
        if names[..index].iter().any(|(_, earlier)| earlier == name) {
            let at = root.at(path).map_or_else(|| root.place.clone(), |node| node.place.clone());
            found.add(
                path,
                Problem::new(at, format!("\"{}\" appears twice", short(name)), format!("another {list} has this name")),
            );
        }
    }
}
