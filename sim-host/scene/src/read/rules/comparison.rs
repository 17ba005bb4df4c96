//! The comparison: what scales its cases, what they are matched by, and that each of them is a valid scene.

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
        self.case_names();
    }

    /// The key is a number that the scene gives, and a peak of what is driven.
    fn amplitude_key(&mut self) {
        let Some(name) = self.number_named(KEY).map(|(name, _)| name.to_owned()) else { return };
        let problem = if self.kind == Some(Kind::Driven) && name != AMPLITUDE {
            let message = format!("`{}` is not the peak of what the firmware drives", short(&name));
            let label = format!("must be `{AMPLITUDE}`");
            Problem::new(self.place(KEY), message, label).help("the cases are scaled by their peak voltage until they match")
        } else if self.lacks(&name) {
            let message = format!("`{}` is not given in this scene", short(&name));
            Problem::new(self.place(KEY), message, "must be given, for the cases to be scaled from")
        } else if self.number(&name).is_some_and(|number| number <= 0.0) {
            let message = format!("`{}` is zero, which no factor scales", short(&name));
            Problem::new(self.place(KEY), message, "must be more than zero in this scene")
        } else {
            return;
        };
        self.add(KEY, problem);
    }

    fn matches(&mut self) {
        let names = self.names(MATCH, "");
        self.each_once(&names, "is matched already");
        for (path, name) in names {
            if self.kind == Some(Kind::Excited) && name != "peak" {
                let message = format!("a contact study has no electrical {name}");
                let problem = Problem::new(self.place(&path), message, "must be \"peak\"");
                self.add(&path, problem.help("`excitation.match` makes the rms of the excitation equal"));
            }
        }
    }

    fn case_names(&mut self) {
        let names = self.names(CASES, "name");
        self.each_once(&names, "is another case's name");
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
                let message = format!("a case cannot set `{key}`, by which it is scaled");
                let problem = Problem::new(place, message, "the comparison sets it");
                self.add(&path, problem.help("`comparison.set` may set it, for all cases"));
            }
        }
    }

    /// The strings of a list, or of a key in each entry of it, with their paths.
    fn names(&self, list: &str, key: &str) -> Vec<(String, String)> {
        let entries = 0..self.root.at(list).map_or(0, |list| list.list().len());
        let path = |index: usize| if key.is_empty() { format!("{list}.{index}") } else { format!("{list}.{index}.{key}") };
        entries.map(path).filter_map(|path| self.text(&path).map(str::to_owned).map(|name| (path, name))).collect()
    }

    fn each_once(&mut self, names: &[(String, String)], label: &str) {
        for (index, (path, name)) in names.iter().enumerate() {
            if names[..index].iter().any(|(_, earlier)| earlier == name) {
                let problem = Problem::new(self.place(path), format!("\"{}\" stands here twice", short(name)), label);
                self.add(path, problem);
            }
        }
    }

    /// An expectation of a case names one that there is, and what it is matched by.
    pub(super) fn of_a_case(&mut self, path: &str) {
        let (case, matched) = (join(path, "case"), join(path, "match"));
        let (given, missing) = match (self.given(&case), self.given(&matched)) {
            (false, false) => return,
            (true, false) => (&case, &matched),
            (false, true) => (&matched, &case),
            (true, true) => {
                self.one_of(&case, CASES, "name", "the comparison has no case");
                return self.one_of(&matched, MATCH, "", "the comparison does not match by");
            }
        };
        if self.clean(missing) {
            let (given_key, key) = (last_name(given), last_name(missing));
            let problem = Problem::new(self.key(given), format!("`{given_key}` needs `{key}`, too"), format!("without `{key}`"));
            self.add(given, problem.help("a case is run at equal peak, rms or power: say which"));
        }
    }

    fn one_of(&mut self, path: &str, list: &str, key: &str, message: &str) {
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

    /// Makes every case.
    pub(super) fn cases(&mut self) {
        if !self.findings.problems.is_empty() {
            return;
        }
        // Before any of them is found wrong, because what is wrong is not read again.
        let cases = self.tables(CASES);
        let names: Vec<String> = cases.iter().map(|path| self.text(&join(path, "name")).unwrap_or_default().to_owned()).collect();
        for (path, name) in cases.into_iter().zip(names) {
            let own = self.sets(&join(&path, "set"));
            let table = self.root.at(&path).map_or_else(|| self.place(CASES), |node: &Node| node.place.clone());
            let cell = Cell {
                table: "comparison",
                called: format!("in the case `{}`", short(&name)),
                whole: if own.is_empty() { table } else { self.key(&join(&path, "set")) },
                help: "each case is this scene with `comparison.set` and its own `set` laid over it: make them fit",
            };
            let made = self.cell(&cell, self.sets("comparison.set").into_iter().chain(own));
            self.picture(&join(&path, "picture"), made.as_ref());
        }
    }

    /// A picture is of a sweep whose frequencies are known.
    fn picture(&mut self, path: &str, made: Option<&Node>) {
        let Some(made) = made.filter(|_| matches!(self.value(path).map(|node| &node.value), Some(Value::Flag(true)))) else {
            return;
        };
        let about_resonance = made.at("controller.sweep.around").and_then(Node::text) == Some("resonance");
        if made.at("controller.sweep").is_none() || about_resonance {
            let problem =
                Problem::new(self.place(path), "a picture without a sweep", "this case has no sweep of known frequencies");
            self.add(path, problem.help("time-frequency pictures are of a [controller.sweep] that is not about the resonance"));
        }
    }
}
