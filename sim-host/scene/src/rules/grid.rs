//! The grid: each of its cells must be a valid scene, too.

use super::Rules;
use super::cells::Cell;
use crate::Grid;
use crate::diagnostic::Problem;
use crate::nearest::{nearest, short};
use crate::schema::Schema;
use crate::tree::Node;
use crate::walk::wrong_number;

impl<'a> Rules<'a> {
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
        let Some((name, schema)) = self.number_named(key) else { return };
        let list = self.value(values).map_or(&[][..], Node::list);
        let wrong: Vec<_> = list.iter().filter_map(|number| wrong_number(number, schema, name)).collect();
        wrong.into_iter().for_each(|problem| self.add(values, problem));
    }

    /// The number of a scene that a key names.
    pub(super) fn number_named(&mut self, key: &str) -> Option<(&'a str, Schema)> {
        let name = self.text(key)?;
        if let Some(schema) = Schema::root().at(name).filter(|schema| schema.is_number()) {
            return Some((name, schema));
        }
        let numbers = Schema::numbers();
        let meant = nearest(name, numbers.iter().map(String::as_str));
        let label = meant.first().map_or("no such key".to_owned(), |meant| format!("did you mean `{meant}`?"));
        let problem = Problem::new(self.place(key), format!("`{}` is no number of a scene", short(name)), label);
        self.add(key, problem.help("tables and key, with points between: \"rig.slider.load_n\""));
        None
    }

    /// Makes the first cell.
    pub(super) fn cells(&mut self) {
        let grid = self.root.at("grid").filter(|_| self.findings.problems.is_empty());
        let Some(grid) = grid.and_then(|grid| grid.to_toml().try_into::<Grid>().ok()) else { return };
        let first = |values: &[f64]| values.first().copied().unwrap_or_default();
        let axes = [
            (format!("{}={}", grid.row_key, first(&grid.rows)), self.place("grid.row_key")),
            (format!("{}={}", grid.column_key, first(&grid.columns)), self.place("grid.column_key")),
        ];
        let cell = Cell {
            table: "grid",
            called: "in the cells of the grid".to_owned(),
            whole: if grid.set.is_empty() { self.place("grid") } else { self.key("grid.set") },
            help: "each cell is this scene with `grid.set` laid over it: make them fit",
        };
        self.cell(&cell, self.sets("grid.set").into_iter().chain(axes));
    }
}
