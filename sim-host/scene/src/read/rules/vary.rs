//! What varies from run to run: each must be a number that the scene has, and both of its ends a valid scene.

use super::Rules;
use super::cells::{Cell, NOT_IN_A_CELL};
use crate::Vary;
use crate::diagnostic::Problem;
use crate::nearest::shown;
use crate::schema::{Schema, join};

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
            if name == SEED || NOT_IN_A_CELL.contains(&table) {
                let help = "what varies is a number of the plant, or a nominal value of the controller";
                wrong(format!("`{name}` cannot be varied"), "no run has a value of its own here", help);
                continue;
            }
            let earlier = |earlier: &String| self.root.at(&join(earlier, "key")).and_then(|node| node.text()) == Some(name);
            if tables[..index].iter().any(earlier) {
                self.add(&key, Problem::new(place, format!("`{name}` is varied twice"), "second time"));
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
                let problem = Problem::new(place, format!("a part of 0 is 0: `{name}` would not vary"), "is 0 in this scene");
                self.add(&key, problem.help("give `from` and `to` instead"));
            } else {
                self.in_order(path);
            }
        }
        self.nothing_beside();
    }

    pub(super) fn in_order(&mut self, path: &str) {
        let (from, to) = (join(path, "from"), join(path, "to"));
        if let (Some(low), Some(high)) = (self.number(&from), self.number(&to))
            && low >= high
        {
            let message = format!("nothing is from {} to {}", shown(low), shown(high));
            let at = self.newer(&to, &from);
            self.add(&to, Problem::new(self.place(at), message, "`to` must be more than `from`"));
        }
    }

    /// A comparison is run beside a scene that is run once.
    fn nothing_beside(&mut self) {
        if self.number(RUNS).is_some_and(|runs| runs > 1.0) && self.given("comparison") {
            let problem = Problem::new(self.place(RUNS), "a scene of several `runs` has no [comparison]", "must be 1");
            self.add(RUNS, problem.help("[comparison] is run beside a scene that is run once"));
        }
    }

    /// Makes the scenes at both ends of each variation.
    pub(super) fn ends(&mut self) {
        if !self.findings.problems.is_empty() {
            return;
        }
        for path in self.tables(TABLE) {
            let vary = self.root.at(&path).and_then(|table| table.to_toml().try_into::<Vary>().ok());
            let Some((vary, own)) = vary.and_then(|vary| Some((self.number(&vary.key)?, vary))).map(|(own, vary)| (vary, own))
            else {
                continue;
            };
            for part in [0.0, 1.0] {
                let value = vary.value(own, part);
                let place = self.place(&join(&path, "key"));
                let cell = Cell {
                    table: TABLE,
                    called: format!("`{}` varied to {}", vary.key, shown(value)),
                    whole: place.clone(),
                    help: "each run is this scene with what varies laid over it: make them fit, or vary it less",
                };
                if self.cell(&cell, [(format!("{}={value:?}", vary.key), place)]).is_none() {
                    break;
                }
            }
        }
    }
}
