//! Rules of `[[vary]]`: each key must be a number of the scene, and the scene must be valid at both
//! ends of its range.

use super::Rules;
use super::cells::{Cell, NON_CELL_KEYS};
use crate::Vary;
use crate::diagnostic::Problem;
use crate::nearest::shown;
use crate::schema::{Kind, Schema, join};

const TABLE: &str = "vary";
const RUNS: &str = "runs";
const SEED: &str = "seed";

impl Rules<'_> {
    pub(super) fn variations(&mut self) {
        let tables = self.tables(TABLE);
        for (index, path) in tables.iter().enumerate() {
            let key = join(path, "key");
            let Some((name, _)) = self.number_named(&key) else { continue };
            let place = self.place(&key);
            let mut wrong = |message: String, label: &str, help: &str| {
                let problem = Problem::new(place.clone(), message, label);
                self.add(&key, if help.is_empty() { problem } else { problem.help(help) });
            };
            let table = name.split('.').next().unwrap_or(name);
            if name == SEED || NON_CELL_KEYS.contains(&table) {
                let help = "only numbers of the plant and nominal values of the controller can be varied";
                wrong(format!("`{name}` cannot be varied"), "the same in every run", help);
                continue;
            }
            let earlier = |earlier: &String| self.root.at(&join(earlier, "key")).and_then(|node| node.text()) == Some(name);
            if tables[..index].iter().any(earlier) {
                self.add(&key, Problem::new(place, format!("`{name}` is varied twice"), "second occurrence"));
                continue;
            }
            let relative = ["spread", "factor"].iter().any(|way| self.given(&join(path, way)));
            let own = self.number(name);
            if self.lacks(name) && own.is_none() {
                let meaning = Schema::root().at(name).and_then(Schema::description).unwrap_or_default();
                let problem =
                    Problem::new(place, format!("`{name}` is varied, but the scene does not have it"), "not in this scene");
                self.add(&key, problem.help(format!("give it a value first; it is optional: {meaning}")));
            } else if relative && own == Some(0.0) {
                let problem = Problem::new(
                    place,
                    format!("`spread` and `factor` are relative: `{name}` would not vary"),
                    "is 0 in this scene",
                );
                self.add(&key, problem.help("give `from` and `to` instead"));
            } else {
                self.in_order(path);
            }
        }
        self.check_single_run();
    }

    pub(super) fn in_order(&mut self, path: &str) {
        let (from, to) = (join(path, "from"), join(path, "to"));
        if let (Some(low), Some(high)) = (self.number(&from), self.number(&to))
            && low >= high
        {
            let message = format!("the range from {} to {} is empty", shown(low), shown(high));
            let at = self.newer(&to, &from);
            self.add(&to, Problem::new(self.place(at), message, "`to` must be more than `from`"));
        }
    }

    /// Checks that a scene with a comparison is run once.
    fn check_single_run(&mut self) {
        if self.number(RUNS).is_some_and(|runs| runs > 1.0) && self.given("comparison") {
            let problem = Problem::new(self.place(RUNS), "a scene with several `runs` cannot have a [comparison]", "must be 1");
            self.add(RUNS, problem.help("[comparison] needs a scene that is run once"));
        }
    }

    /// Builds and checks the scenes at both ends of each variation.
    pub(super) fn check_ends(&mut self) {
        if !self.findings.problems.is_empty() {
            return;
        }
        for path in self.tables(TABLE) {
            let vary = self.root.at(&path).and_then(|table| table.to_toml().try_into::<Vary>().ok());
            let Some((vary, own)) = vary.and_then(|vary| Some((self.number(&vary.key)?, vary))).map(|(own, vary)| (vary, own))
            else {
                continue;
            };
            let schema = Schema::root().at(&vary.key);
            let whole = schema.is_some_and(|schema| schema.kind() == Kind::Integer);
            for value in vary.ends(own, schema.map_or((None, None), Schema::range)) {
                let value = if whole { value.round() } else { value };
                let place = self.place(&join(&path, "key"));
                let cell = Cell {
                    table: TABLE,
                    called: format!("`{}` varied to {}", vary.key, shown(value)),
                    whole: place.clone(),
                    help: "each run is this scene with the drawn value: make the scene valid at both ends, or vary it less",
                };
                if self.build_cell(&cell, [(format!("{}={value:?}", vary.key), place)]).is_none() {
                    break;
                }
            }
        }
    }
}
