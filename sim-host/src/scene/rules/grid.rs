//! The grid: each of its cells must be a valid scene, too.

use super::{Rules, check, walk};
use crate::scene::Grid;
use crate::scene::diagnostic::{Place, Problem};
use crate::scene::nearest::{nearest, short};
use crate::scene::overlay::{overlay, parse_set, put_all_at};
use crate::scene::schema::Schema;
use crate::scene::tree::{Node, Origin, Value};
use crate::scene::walk::wrong_number;

impl Rules<'_> {
    /// The metric, and what rows and columns change.
    pub(super) fn axes(&mut self) {
        self.metric("grid.metric");
        let (row, column) = (self.text("grid.row_key"), self.text("grid.column_key"));
        self.axis("grid.row_key", "grid.rows");
        self.axis("grid.column_key", "grid.columns");
        if row.is_some() && row == column {
            let problem =
                Problem::new(self.place("grid.column_key"), "rows and columns change the same key", "same as `row_key`");
            self.add("grid.column_key", problem);
        }
    }

    /// An axis changes a number of the scene, to values which that number may have.
    fn axis(&mut self, key: &str, values: &str) {
        let Some(name) = self.text(key) else { return };
        let Some(schema) = Schema::root().at(name).filter(|schema| schema.is_number()) else {
            let numbers = Schema::numbers();
            let meant = nearest(name, numbers.iter().map(String::as_str));
            let label = meant.first().map_or("no such key".to_owned(), |meant| format!("did you mean `{meant}`?"));
            let problem = Problem::new(self.place(key), format!("`{}` is no number of a scene", short(name)), label);
            return self.add(key, problem.help("tables and key, with points between: \"rig.slider.load_n\""));
        };
        let list = self.value(values).map_or(&[][..], Node::list);
        let wrong: Vec<_> = list.iter().filter_map(|number| wrong_number(number, schema, name)).collect();
        wrong.into_iter().for_each(|problem| self.add(values, problem));
    }

    /// Makes the first cell. The scene is right by itself, so all that is wrong now is the grid's doing.
    pub(super) fn cells(&mut self) {
        let grid = self.root.at("grid").filter(|_| self.findings.problems.is_empty());
        let Some(grid) = grid.and_then(|grid| grid.to_toml().try_into::<Grid>().ok()) else { return };
        let mut cell = self.root.clone();
        if let Value::Table(table) = &mut cell.value {
            table.remove("grid");
        }
        let sets = grid.set.iter().enumerate().map(|(index, set)| (set.clone(), self.place(&format!("grid.set.{index}"))));
        let first = |values: &[f64]| values.first().copied().unwrap_or_default();
        let axes = [
            (format!("{}={}", grid.row_key, first(&grid.rows)), self.place("grid.row_key")),
            (format!("{}={}", grid.column_key, first(&grid.columns)), self.place("grid.column_key")),
        ];
        let mut problems = Vec::new();
        for (set, place) in sets.chain(axes) {
            match parse_set(&set, Origin { source: place.source, offset: 0 }) {
                Ok(mut over) => {
                    put_all_at(&mut over, &place);
                    overlay(&mut cell, over, "", &mut problems);
                }
                Err(problem) => problems.push(Problem { at: place, ..problem }),
            }
        }
        if problems.is_empty() {
            let walked = walk(&mut cell);
            problems = check(&cell, walked).problems;
        }
        let whole = if grid.set.is_empty() { self.place("grid") } else { self.key("grid.set") };
        for problem in problems {
            self.blame(&whole, problem);
        }
    }

    fn blame(&mut self, whole: &Place, problem: Problem) {
        let inside = self.root.at("grid").is_some_and(|grid| has_place(grid, &problem.at));
        let message = format!("in the cells of the grid: {}", problem.message);
        let problem = Problem { message, ..problem };
        let help = "each cell is this scene with `grid.set` laid over it: make them fit";
        self.add("grid", if inside { problem } else { Problem { at: whole.clone(), ..problem.help(help) } });
    }
}

fn has_place(node: &Node, place: &Place) -> bool {
    let inner = match &node.value {
        Value::Table(table) => table.values().any(|entry| has_place(&entry.node, place)),
        _ => node.list().iter().any(|node| has_place(node, place)),
    };
    inner || node.place == *place
}
