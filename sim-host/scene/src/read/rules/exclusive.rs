//! The rule for keys and tables that exclude each other.

use super::Rules;
use crate::diagnostic::Problem;
use crate::exclusive::{Alternative, Exclusive};
use crate::nearest::listed;
use crate::schema::{Kind, Schema, join};
use crate::tree::Node;
use crate::wording::{header, within};

impl Rules<'_> {
    pub(super) fn exclusive(&mut self, group: &Exclusive, path: &str) {
        let keys: Vec<_> = group.alternatives.iter().flat_map(|way| way.keys).map(|key| join(path, key)).collect();
        let Some(table) = self.root.at(path).filter(|_| keys.iter().all(|key| self.sound(key))).and_then(Node::table) else {
            return;
        };
        let given = |way: &Alternative| way.keys.iter().filter(|key| table.contains_key(**key)).copied().collect::<Vec<_>>();
        let ways: Vec<_> = group.alternatives.iter().map(|way| (way, given(way))).filter(|(_, keys)| !keys.is_empty()).collect();
        let called = |key: &str| called(path, key);
        let choice = {
            let ways = group.alternatives.iter().map(|way| match way.keys {
                [key] => called(key),
                keys => listed(keys.iter().copied(), if way.complete { "and" } else { "or" }),
            });
            format!("give either {}", ways.collect::<Vec<_>>().join(", or "))
        };
        let problem = match ways.as_slice() {
            [] => {
                let message = format!("{} is incomplete", header(path));
                Problem::new(self.place(path), message, choice)
            }
            [(way, keys)] if way.complete && keys.len() < way.keys.len() => {
                let missing = listed(way.keys.iter().copied().filter(|key| !keys.contains(key)), "and");
                let Some(first) = keys.first() else { return };
                let needs = if keys.len() == 1 { "needs" } else { "need" };
                let message = format!("{} {needs} {missing} as well", listed(keys.iter().copied(), "and"));
                Problem::new(self.key(&join(path, first)), message, format!("without {missing}")).help(choice)
            }
            [_] => return,
            [(_, first), (_, second), ..] => {
                let (Some(first), Some(second)) = (first.first(), second.first()) else { return };
                let message = format!("{} and {} exclude each other {}", called(first), called(second), within(path));
                let (one, other) = (self.key(&join(path, first)), self.key(&join(path, second)));
                let (later, earlier) = if one < other { (other, first) } else { (one, second) };
                Problem::new(later, message, format!("{} is already given", called(earlier))).help(choice)
            }
        };
        self.findings.problems.push(problem);
        keys.into_iter().for_each(|key| self.findings.mark(key));
    }

    /// Returns `true` if a key, or its absence, has no problem. Problems inside a table are
    /// ignored.
    fn sound(&self, path: &str) -> bool {
        let table = self.root.at(path).and_then(Node::table).is_some();
        if table { !self.findings.marked(path) } else { self.clean(path) }
    }
}

/// Returns a key in backquotes, or the header of a table.
fn called(path: &str, key: &str) -> String {
    let inner = join(path, key);
    let table = Schema::root().at(&inner).is_some_and(|schema| schema.kind() == Kind::Table);
    if table { header(&inner) } else { format!("`{key}`") }
}
