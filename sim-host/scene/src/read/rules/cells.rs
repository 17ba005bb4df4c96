//! Rules of derived scenes: the cells of a grid and the cases of a comparison must be valid scenes.

use super::{Rules, check, walk};
use crate::diagnostic::{Place, Problem};
use crate::overlay::{overlay, parse_set, put_all_at};
use crate::tree::{Node, Origin, Value};

/// Keys that a cell does not have: its number of runs, further runs, and expectations.
pub(super) const NON_CELL_KEYS: [&str; 5] = ["runs", "vary", "grid", "comparison", "expect"];

/// Removes the keys that a cell does not have.
pub(crate) fn remove_non_cell_keys(root: &mut Node) {
    if let Value::Table(table) = &mut root.value {
        NON_CELL_KEYS.iter().for_each(|name| drop(table.remove(*name)));
    }
}

/// Description of a cell, for messages.
pub(super) struct Cell<'a> {
    /// The table that defines it.
    pub(super) table: &'static str,
    /// Its name in a message, for example "in the cells of the grid".
    pub(super) called: String,
    /// Place to mark if the cause is elsewhere in the scene.
    pub(super) whole: Place,
    /// Help text.
    pub(super) help: &'a str,
}

impl Rules<'_> {
    /// Builds a cell with changes, each with its place. The scene itself is valid, so any problem
    /// is caused by these changes. Returns the cell if it is valid.
    pub(super) fn build_cell(&mut self, cell: &Cell, sets: impl IntoIterator<Item = (String, Place)>) -> Option<Node> {
        let mut root = self.root.clone();
        remove_non_cell_keys(&mut root);
        let mut problems = Vec::new();
        for (set, place) in sets {
            match parse_set(&set, Origin { source: place.source, offset: 0 }) {
                Ok(mut over) => {
                    put_all_at(&mut over, &place);
                    overlay(&mut root, over, "", &mut problems);
                }
                Err(problem) => problems.push(Problem { at: place, ..problem }),
            }
        }
        if problems.is_empty() {
            let walked = walk(&mut root);
            problems = check(&root, walked).problems;
        }
        let made = problems.is_empty().then_some(root);
        for problem in problems {
            self.add_cell_problem(cell, problem);
        }
        made
    }

    fn add_cell_problem(&mut self, cell: &Cell, problem: Problem) {
        let inside = self.root.at(cell.table).is_some_and(|table| has_place(table, &problem.at));
        let message = format!("{}: {}", cell.called, problem.message);
        let problem = Problem { message, ..problem };
        self.add(cell.table, if inside { problem } else { Problem { at: cell.whole.clone(), ..problem.help(cell.help) } });
    }

    /// Returns the strings of a list with their places.
    pub(super) fn sets(&self, path: &str) -> Vec<(String, Place)> {
        let list = self.root.at(path).map_or(&[][..], Node::list);
        list.iter().filter_map(|node| Some((node.text()?.to_owned(), node.place.clone()))).collect()
    }
}

fn has_place(node: &Node, place: &Place) -> bool {
    let inner = match &node.value {
        Value::Table(table) => table.values().any(|entry| has_place(&entry.node, place)),
        _ => node.list().iter().any(|node| has_place(node, place)),
    };
    inner || node.place == *place
}
