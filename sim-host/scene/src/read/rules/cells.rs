//! What is made of a scene by setting keys of it, the cells of a grid and the cases of a comparison, must be valid scenes, too.

use super::{Rules, check, walk};
use crate::diagnostic::{Place, Problem};
use crate::overlay::{overlay, parse_set, put_all_at};
use crate::tree::{Node, Origin, Value};

/// What a scene has and a cell of it does not: how often it is run, what is run beside it, and what is expected of it.
pub(super) const NOT_IN_A_CELL: [&str; 5] = ["runs", "vary", "grid", "comparison", "expect"];

/// Leaves of a scene what a cell of it has.
pub(crate) fn alone(root: &mut Node) {
    if let Value::Table(table) = &mut root.value {
        NOT_IN_A_CELL.iter().for_each(|name| drop(table.remove(*name)));
    }
}

/// What a cell is part of, for a message.
pub(super) struct Cell<'a> {
    /// The table that makes it.
    pub(super) table: &'static str,
    /// Where it is: "in the cells of the grid".
    pub(super) called: String,
    /// Where to point if the reason lies elsewhere in the scene.
    pub(super) whole: Place,
    /// What to do about it.
    pub(super) help: &'a str,
}

impl Rules<'_> {
    /// Makes a cell, each change with the place it stands at. The scene is right by itself, so all that is wrong now is the doing of
    /// these changes. Returns what it made, unless it is wrong.
    pub(super) fn cell(&mut self, cell: &Cell, sets: impl IntoIterator<Item = (String, Place)>) -> Option<Node> {
        let mut root = self.root.clone();
        alone(&mut root);
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
            self.blame(cell, problem);
        }
        made
    }

    fn blame(&mut self, cell: &Cell, problem: Problem) {
        let inside = self.root.at(cell.table).is_some_and(|table| has_place(table, &problem.at));
        let message = format!("{}: {}", cell.called, problem.message);
        let problem = Problem { message, ..problem };
        self.add(cell.table, if inside { problem } else { Problem { at: cell.whole.clone(), ..problem.help(cell.help) } });
    }

    /// The strings of a list with their places.
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
