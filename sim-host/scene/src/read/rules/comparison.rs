//! Rules of the comparison: the scaled key, the matched quantities, and valid cases.

use super::cells::Cell;
use super::drive::AMPLITUDE;
use super::kind::Kind;
use super::{Rules, join, listed, nearest, short};
use crate::diagnostic::Problem;
use crate::schema::last_name;
use crate::tree::{Node, Value};

const KEY: &str = "comparison.amplitude_key";
const MATCH: &str = "comparison.match";
const CASES: &str = "comparison.case";

impl Rules<'_> {
    pub(super) fn comparison(&mut self) {
        for index in 0..self.root.at("comparison.metrics").map_or(0, |list| list.list().len()) {
            self.metric(&format!("comparison.metrics.{index}"));
        }
        self.amplitude_key();
        self.matches();
        self.check_case_names();
    }

    /// Checks that the key is a number that the scene gives, and a peak of the drive.
    fn amplitude_key(&mut self) {
        let Some(name) = self.number_named(KEY).map(|(name, _)| name.to_owned()) else { return };
        let problem = if self.kind == Some(Kind::Driven) && name != AMPLITUDE {
            let message = format!("`{}` is not the peak of the firmware's drive", short(&name));
            let label = format!("must be `{AMPLITUDE}`");
            Problem::new(self.place(KEY), message, label).help("the cases are scaled by their peak voltage until they match")
        } else if self.lacks(&name) {
            let message = format!("`{}` is not given in this scene", short(&name));
            Problem::new(self.place(KEY), message, "must be given, as the starting value of the cases")
        } else if self.number(&name).is_some_and(|number| number <= 0.0) {
            let message = format!("`{}` is zero, and cannot be scaled", short(&name));
            Problem::new(self.place(KEY), message, "must be more than zero in this scene")
        } else {
            return;
        };
        self.add(KEY, problem);
    }

    fn matches(&mut self) {
        let names = self.names(MATCH, "");
        self.check_unique(&names, "is already in the list");
        for (path, name) in names {
            if self.kind == Some(Kind::Excited) && name != "peak" {
                let message = format!("a contact study cannot be compared at equal {name}");
                let problem = Problem::new(self.place(&path), message, "must be \"peak\"");
                self.add(&path, problem.help("`excitation.match` makes the rms of the excitation equal"));
            }
            if self.kind == Some(Kind::Driven) && name == "reduction" && !self.given("rig.slider") {
                let message = "without a slider, the cases have no reduction of the friction".to_owned();
                let problem = Problem::new(self.place(&path), message, "nothing slides");
                self.add(&path, problem.help("[rig.slider] slides on the tip; `match = [\"power\"]` needs none"));
            }
        }
    }

    fn check_case_names(&mut self) {
        let names = self.names(CASES, "name");
        self.check_unique(&names, "is the name of another case");
        for (path, name) in &names {
            if name.trim().is_empty() {
                let problem =
                    Problem::new(self.place(path), "a case without a name", "needs a name, for tables and expectations");
                self.add(path, problem);
            }
        }
        let Some(key) = self.text(KEY) else { return };
        for path in self.tables(CASES) {
            let scaled =
                self.sets(&join(&path, "set")).into_iter().find(|(set, _)| set.split('=').next().map(str::trim) == Some(key));
            if let Some((_, place)) = scaled {
                let message = format!("a case cannot set `{key}`, because the comparison scales it");
                let problem = Problem::new(place, message, "the comparison sets it");
                self.add(&path, problem.help("`comparison.set` may set it, for all cases"));
            }
        }
    }

    /// Returns the strings of a list, or of a key in each of its entries, with their paths.
    fn names(&self, list: &str, key: &str) -> Vec<(String, String)> {
        let entries = 0..self.root.at(list).map_or(0, |list| list.list().len());
        let path = |index: usize| if key.is_empty() { format!("{list}.{index}") } else { format!("{list}.{index}.{key}") };
        entries.map(path).filter_map(|path| self.text(&path).map(str::to_owned).map(|name| (path, name))).collect()
    }

    fn check_unique(&mut self, names: &[(String, String)], label: &str) {
        for (index, (path, name)) in names.iter().enumerate() {
            if names[..index].iter().any(|(_, earlier)| earlier == name) {
                let problem = Problem::new(self.place(path), format!("\"{}\" appears twice", short(name)), label);
                self.add(path, problem);
            }
        }
    }

    /// Checks that the case and the match of an expectation exist.
    pub(super) fn check_case(&mut self, path: &str) {
        let (case, matched) = (join(path, "case"), join(path, "match"));
        let (given, missing) = match (self.given(&case), self.given(&matched)) {
            (false, false) => return,
            (true, false) => (&case, &matched),
            (false, true) => (&matched, &case),
            (true, true) => {
                self.check_name(&case, CASES, "name", "the comparison has no case");
                return self.check_name(&matched, MATCH, "", "the comparison does not match by");
            }
        };
        if self.clean(missing) {
            let (given_key, key) = (last_name(given), last_name(missing));
            let problem =
                Problem::new(self.key(given), format!("`{given_key}` needs `{key}` as well"), format!("without `{key}`"));
            self.add(given, problem.help("a case is run at equal peak, rms, power or reduction: state which"));
        }
    }

    fn check_name(&mut self, path: &str, list: &str, key: &str, message: &str) {
        let names = self.names(list, key);
        let Some(name) = self.text(path).filter(|name| names.iter().all(|(_, known)| known != name)) else { return };
        if !self.clean(list) {
            return;
        }
        let known = || names.iter().map(|(_, known)| known.as_str());
        let label = match nearest(name, known()).first() {
            Some(meant) => format!("did you mean `{meant}`?"),
            None if names.is_empty() => "there is no [comparison]".to_owned(),
            None => format!("it has {}", listed(known(), "and")),
        };
        let problem = Problem::new(self.place(path), format!("{message} `{}`", short(name)), label);
        self.add(path, problem);
    }

    /// Builds and checks every case.
    pub(super) fn check_cases(&mut self) {
        if !self.findings.problems.is_empty() {
            return;
        }
        // Read before the checks, because keys with problems can no longer be read.
        let cases = self.tables(CASES);
        let names: Vec<String> = cases.iter().map(|path| self.text(&join(path, "name")).unwrap_or_default().to_owned()).collect();
        for (path, name) in cases.into_iter().zip(names) {
            let own = self.sets(&join(&path, "set"));
            let table = self.root.at(&path).map_or_else(|| self.place(CASES), |node: &Node| node.place.clone());
            let cell = Cell {
                table: "comparison",
                called: format!("in the case `{}`", short(&name)),
                whole: if own.is_empty() { table } else { self.key(&join(&path, "set")) },
                help: "each case is this scene with the changes of `comparison.set` and of its own `set`: change these",
            };
            let made = self.build_cell(&cell, self.sets("comparison.set").into_iter().chain(own));
            self.check_picture(&join(&path, "picture"), made.as_ref());
        }
    }

    /// Checks that a picture is of a sweep with known frequencies.
    fn check_picture(&mut self, path: &str, made: Option<&Node>) {
        let Some(made) = made.filter(|_| matches!(self.value(path).map(|node| &node.value), Some(Value::Flag(true)))) else {
            return;
        };
        let about_resonance = made.at("controller.sweep.around").and_then(Node::text) == Some("resonance");
        if made.at("controller.sweep").is_none() || about_resonance {
            let problem =
                Problem::new(self.place(path), "a picture without a sweep", "this case has no sweep of known frequencies");
            self.add(path, problem.help("time-frequency pictures need a [controller.sweep] that is not around the resonance"));
        }
    }
}
