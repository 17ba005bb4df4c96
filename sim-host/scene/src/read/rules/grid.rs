//! Rules of the grid: each of its points must be a valid scene.

use super::Rules;
use super::cells::{Cell, NON_CELL_KEYS};
use crate::diagnostic::Problem;
use crate::nearest::{nearest, short};
use crate::schema::{Schema, join};
use crate::tree::{Node, Value};
use crate::walk::wrong_number;
use crate::{Grid, Over};

const OVER: &str = "grid.over";

/// Largest number of points of a grid: all are held in memory, and a run that is stopped keeps
/// none.
const MAX_POINTS: f64 = 1e4;

impl<'a> Rules<'a> {
    /// Checks the metrics and the axes.
    pub(super) fn axes(&mut self) {
        let names = self.root.at("grid.metrics").map_or(0, |names| names.list().len());
        let metrics: Vec<String> = (0..names).map(|index| format!("grid.metrics.{index}")).collect();
        for (index, path) in metrics.iter().enumerate() {
            self.metric(path);
            let twice = |earlier: &String| self.text(earlier).is_some() && self.text(earlier) == self.text(path);
            if metrics[..index].iter().any(twice) {
                self.add(path, Problem::new(self.place(path), "a metric appears twice", "second occurrence"));
            }
        }
        let over = self.tables(OVER);
        for (index, path) in over.iter().enumerate() {
            let key = join(path, "key");
            self.axis(path);
            let name = self.text(&key);
            if name.is_some() && over[..index].iter().any(|earlier| self.text(&join(earlier, "key")) == name) {
                let problem = Problem::new(self.place(&key), "two axes of the grid change the same key", "second occurrence");
                self.add(&key, problem);
            }
        }
        let counts = over.iter().map(|path| match self.root.at(&join(path, "values")) {
            Some(values) => values.list().len() as f64,
            None => self.number(&join(path, "points")).unwrap_or(1.0),
        });
        let points: f64 = counts.product();
        if points > MAX_POINTS {
            let problem = Problem::new(self.key(OVER), format!("a grid of {points} points"), "at most 10 000 in all");
            self.add(OVER, problem.help("`sim-host sweep` has no such limit, and can continue after a stop"));
        }
    }

    /// Checks that an axis changes a number of the scene, to valid values.
    fn axis(&mut self, path: &str) {
        let key = join(path, "key");
        let Some((name, schema)) = self.number_named(&key) else { return };
        if name == "seed" || NON_CELL_KEYS.contains(&name.split('.').next().unwrap_or(name)) {
            let problem = Problem::new(
                self.place(&key),
                format!("`{name}` is the same at every point"),
                "cannot change from point to point",
            );
            self.add(&key, problem.help("a grid changes a number of the plant, the contact or the controller"));
            return;
        }
        let (values, from, to) = (join(path, "values"), join(path, "from"), join(path, "to"));
        let list = self.value(&values).map_or(&[][..], Node::list);
        let ends = [&from, &to].map(|end| (end, self.value(end)));
        let given = list.iter().map(|number| (&values, number));
        let given = given.chain(ends.into_iter().filter_map(|(end, number)| Some((end, number?))));
        let wrong: Vec<_> = given.filter_map(|(at, number)| Some((at, wrong_number(number, schema, name)?))).collect();
        wrong.into_iter().for_each(|(at, problem)| self.add(at, problem));
        self.in_order(path);
        let log = join(path, "log");
        if self.value(&log).is_some_and(|log| matches!(log.value, Value::Flag(true))) {
            match self.number(&from) {
                Some(first) if first <= 0.0 => {
                    let problem =
                        Problem::new(self.place(&from), "with equal ratios, all values are above zero", "must be above zero");
                    self.add(&from, problem.help("omit `log`, or begin with a small number above zero"));
                }
                None if self.lacks(&from) => {
                    let problem = Problem::new(self.key(&log), "`log` needs a range", "there is no `from`");
                    self.add(&log, problem.help("with `values`, each value is given"));
                }
                _ => {}
            }
        }
    }

    /// Returns the number of a scene that a key names.
    pub(super) fn number_named(&mut self, key: &str) -> Option<(&'a str, Schema)> {
        let name = self.text(key)?;
        if let Some(schema) = Schema::root().at(name).filter(|schema| schema.is_number()) {
            return Some((name, schema));
        }
        let numbers = Schema::numbers();
        let meant = nearest(name, numbers.iter().map(String::as_str));
        let label = meant.first().map_or("no such key".to_owned(), |meant| format!("did you mean `{meant}`?"));
        let problem = Problem::new(self.place(key), format!("`{}` is not a number of a scene", short(name)), label);
        self.add(key, problem.help("tables and key, separated by dots, for example \"rig.slider.load_n\""));
        None
    }

    /// Builds and checks the first cell.
    pub(super) fn check_first_cell(&mut self) {
        let grid = self.root.at("grid").filter(|_| self.findings.problems.is_empty());
        let Some(grid) = grid.and_then(|grid| grid.to_toml().try_into::<Grid>().ok()) else { return };
        let first = |(index, over): (usize, &Over)| {
            let value = over.values.first().copied().or(over.from).unwrap_or_default();
            (format!("{}={value:?}", over.key), self.place(&format!("{OVER}.{index}.key")))
        };
        let axes: Vec<_> = grid.over.iter().enumerate().map(first).collect();
        let cell = Cell {
            table: "grid",
            called: "in the cells of the grid".to_owned(),
            whole: if grid.set.is_empty() { self.place("grid") } else { self.key("grid.set") },
            help: "each cell is this scene with the changes of `grid.set`: change these, or remove the grid with `grid = false`",
        };
        self.build_cell(&cell, self.sets("grid.set").into_iter().chain(axes));
    }
}
