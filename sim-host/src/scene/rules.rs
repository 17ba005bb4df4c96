//! What a schema cannot say: how the keys of a scene depend on each other.
//!
//! A rule reads the keys it looks at, and is silent if one of them is itself wrong, so that one mistake neither raises a second
//! complaint nor hides another one.

mod converters;
mod disturbance;
mod drive;
mod firmware;
mod grid;
mod timeline;
mod tracking;

use super::diagnostic::{Place, Problem};
use super::nearest::{listed, nearest, short, shown};
use super::schema::{Schema, join};
use super::tree::Node;
use super::walk::{Findings, walk};
use super::wording::{header, within};
use crate::metric_names;

/// Keys of a table that exclude each other.
#[derive(Debug)]
pub struct Exclusive {
    /// Path of the table.
    pub table: &'static str,
    /// What one of must be given.
    pub alternatives: &'static [Alternative],
}

/// One way to say it.
#[derive(Debug)]
pub struct Alternative {
    /// The keys of this way.
    pub keys: &'static [&'static str],
    /// Whether all of them are needed, rather than any.
    pub complete: bool,
}

const fn all(keys: &'static [&'static str]) -> Alternative {
    Alternative { keys, complete: true }
}

const fn any(keys: &'static [&'static str]) -> Alternative {
    Alternative { keys, complete: false }
}

/// All groups of keys that exclude each other. Laid over a scene, a key takes the place of those that it excludes.
pub const EXCLUSIVE: &[Exclusive] = &[
    Exclusive { table: "controller.drive", alternatives: &[all(&["amplitude_v"]), all(&["velocity_m_per_s"])] },
    Exclusive { table: "controller.burst", alternatives: &[all(&["on_s", "off_s"]), all(&["period_s", "duty"])] },
    Exclusive {
        table: "stack.bvd",
        alternatives: &[all(&["cm_f", "lm_h", "rm_ohm"]), all(&["series_resonance_hz", "q", "coupling"])],
    },
    Exclusive { table: "disturbance", alternatives: &[all(&["to"]), all(&["rate_per_s"]), all(&["sine_amplitude", "sine_hz"])] },
    Exclusive { table: "expect", alternatives: &[any(&["min", "max"]), all(&["value", "tolerance"])] },
];

/// Checks a scene on which the walk has been: adds to what it found.
pub(super) fn check(root: &Node, findings: Findings) -> Findings {
    let mut rules = Rules { root, findings };
    for group in EXCLUSIVE {
        rules.tables(group.table).iter().for_each(|path| rules.exclusive(group, path));
    }
    rules.contact_and_rig();
    rules.converters();
    rules.drive();
    rules.tracking();
    rules.burst();
    rules.disturbances();
    rules.faults();
    rules.trace();
    rules.expectations();
    rules.axes();
    // The last two judge a scene in which nothing else is wrong: first this one, then the cells made of it.
    rules.firmware();
    rules.cells();
    rules.findings
}

struct Rules<'a> {
    root: &'a Node,
    findings: Findings,
}

impl<'a> Rules<'a> {
    /// Whether nothing is wrong with a value, or with its absence: not if it is there under another name.
    fn clean(&self, path: &str) -> bool {
        self.findings.clean(path) && (self.given(path) || !self.findings.meant(path))
    }

    fn given(&self, path: &str) -> bool {
        self.root.at(path).is_some()
    }

    /// Whether nothing is given at a path, under this name or another.
    fn lacks(&self, path: &str) -> bool {
        !self.given(path) && self.clean(path)
    }

    /// The value at a path, if it is there and right.
    fn value(&self, path: &str) -> Option<&'a Node> {
        self.root.at(path).filter(|_| self.clean(path))
    }

    /// A number of the scene, or its default, if it is right.
    fn number(&self, path: &str) -> Option<f64> {
        match self.root.at(path) {
            Some(_) => self.value(path)?.number(),
            None => self.default(path)?.as_f64(),
        }
    }

    /// A string of the scene, or its default, if it is right.
    fn text(&self, path: &str) -> Option<&'a str> {
        match self.root.at(path) {
            Some(_) => self.value(path)?.text(),
            None => self.default(path)?.as_str(),
        }
    }

    /// A list of numbers, if it is right; nothing in it if it is absent.
    fn numbers(&self, path: &str) -> Option<Vec<f64>> {
        self.clean(path).then(|| self.root.at(path).into_iter().flat_map(Node::list).filter_map(Node::number).collect())
    }

    fn default(&self, path: &str) -> Option<&'static serde_json::Value> {
        Schema::root().at(path).filter(|_| self.clean(path))?.default()
    }

    /// The tables at a path: one, none, or the entries of a list.
    fn tables(&self, path: &str) -> Vec<String> {
        let Some(node) = self.root.at(path) else { return Vec::new() };
        if node.table().is_some() {
            return vec![path.to_owned()];
        }
        (0..node.list().len()).map(|index| join(path, &index.to_string())).collect()
    }

    /// Where a value stands, or else the table it would be in.
    fn place(&self, path: &str) -> Place {
        let mut path = path;
        loop {
            match (self.root.at(path), path.rsplit_once('.')) {
                (Some(node), _) => return node.place.clone(),
                (None, Some((table, _))) => path = table,
                (None, None) => return self.root.place.clone(),
            }
        }
    }

    /// Where a key stands.
    fn key(&self, path: &str) -> Place {
        self.root.entry(path).map_or_else(|| self.place(path), |entry| entry.key.clone())
    }

    /// Of two values that contradict each other, the one to point at: that of the newer text, or else the first.
    fn newer<'p>(&self, path: &'p str, other: &'p str) -> &'p str {
        if self.given(other) && self.place(other).source < self.place(path).source { other } else { path }
    }

    fn add(&mut self, path: &str, problem: Problem) {
        self.findings.add(path, problem);
    }

    fn exclusive(&mut self, group: &Exclusive, path: &str) {
        let keys: Vec<_> = group.alternatives.iter().flat_map(|way| way.keys).map(|key| join(path, key)).collect();
        let Some(table) = self.root.at(path).filter(|_| keys.iter().all(|key| self.clean(key))).and_then(Node::table) else {
            return;
        };
        let given = |way: &Alternative| way.keys.iter().filter(|key| table.contains_key(**key)).copied().collect::<Vec<_>>();
        let ways: Vec<_> = group.alternatives.iter().map(|way| (way, given(way))).filter(|(_, keys)| !keys.is_empty()).collect();
        let choice = {
            let ways =
                group.alternatives.iter().map(|way| listed(way.keys.iter().copied(), if way.complete { "and" } else { "or" }));
            format!("give either {}", ways.collect::<Vec<_>>().join(", or "))
        };
        let problem = match ways.as_slice() {
            [] => {
                let message = format!("{} says too little", header(path));
                Problem::new(self.place(path), message, choice)
            }
            [(way, keys)] if way.complete && keys.len() < way.keys.len() => {
                let missing = listed(way.keys.iter().copied().filter(|key| !keys.contains(key)), "and");
                let Some(first) = keys.first() else { return };
                let needs = if keys.len() == 1 { "needs" } else { "need" };
                let message = format!("{} {needs} {missing}, too", listed(keys.iter().copied(), "and"));
                Problem::new(self.key(&join(path, first)), message, format!("without {missing}")).help(choice)
            }
            [_] => return,
            [(_, first), (_, second), ..] => {
                let (Some(first), Some(second)) = (first.first(), second.first()) else { return };
                let message = format!("`{first}` and `{second}` exclude each other {}", within(path));
                let (one, other) = (self.key(&join(path, first)), self.key(&join(path, second)));
                let (later, earlier) = if one < other { (other, first) } else { (one, second) };
                Problem::new(later, message, format!("`{earlier}` is given already")).help(choice)
            }
        };
        self.findings.problems.push(problem);
        keys.into_iter().for_each(|key| self.findings.mark(key));
    }

    fn contact_and_rig(&mut self) {
        for (given, missing, reason) in [
            ("contact", "rig", "nothing presses on the contact and moves it: add a rig, such as [rig.slider]"),
            ("rig", "contact", "there is no contact to press on and move: add one, such as [contact.dahl]"),
        ] {
            // What is wrong inside the table that is given does not matter here.
            if self.root.at(given).and_then(Node::table).is_some() && self.lacks(missing) {
                let message = format!("[{given}] without [{missing}]");
                let problem = Problem::new(self.place(given), message, format!("needs [{missing}]"));
                self.add(missing, problem.help(reason));
            }
        }
    }

    fn expectations(&mut self) {
        for path in self.tables("expect") {
            self.metric(&join(&path, "metric"));
            let (least, most) = (join(&path, "min"), join(&path, "max"));
            if let (Some(min), Some(max)) = (self.number(&least), self.number(&most))
                && min > max
            {
                let message = format!("nothing is at least {} and at most {}", shown(min), shown(max));
                let place = self.place(self.newer(&most, &least));
                let problem = Problem::new(place, message, "`max` is less than `min`");
                self.add(&most, problem);
            }
        }
    }

    fn metric(&mut self, path: &str) {
        let Some(name) = self.text(path).filter(|name| !metric_names::NAMES.contains(name)) else { return };
        let meant = nearest(name, metric_names::NAMES.iter().copied());
        let label = meant.first().map_or("not measured".to_owned(), |meant| format!("did you mean `{meant}`?"));
        let problem = Problem::new(self.place(path), format!("there is no metric `{}`", short(name)), label);
        let help = format!("the metrics are {}", listed(metric_names::NAMES.iter().copied(), "and"));
        self.add(path, problem.help(help));
    }
}
