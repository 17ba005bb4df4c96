//! What a schema cannot say: how the keys of a scene depend on each other.
//!
//! A rule reads the keys it looks at, and is silent if one of them is itself wrong, so that one mistake neither raises a second
//! complaint nor hides another one.

mod angle;
mod belt;
mod carriage;
mod cells;
pub(crate) mod circuit;
mod comparison;
mod compliant;
mod contact;
mod converters;
mod disturbance;
mod dring;
mod drive;
mod excitation;
mod exclusive;
mod firmware;
mod friction;
mod grid;
mod heat;
mod integrator;
mod kind;
mod lane_fault;
mod motor;
mod overlay;
mod profile;
mod replaced;
mod timeline;
mod tracking;
mod vary;
mod webbing;
mod window;

use crate::diagnostic::{Place, Problem};
use crate::exclusive::EXCLUSIVE;
use crate::metrics;
use crate::nearest::{listed, nearest, short, shown};
use crate::schema::{Schema, join};
use crate::tree::Node;
use crate::walk::{Findings, walk};

pub(crate) use cells::alone;
use kind::Kind;

/// Checks a scene on which the walk has been: adds to what it found.
pub(crate) fn check(root: &Node, findings: Findings) -> Findings {
    let mut rules = Rules { root, findings, kind: None };
    rules.kind();
    rules.belonging();
    for group in EXCLUSIVE {
        if group.table == "stack.bvd" {
            rules.circuit(group);
        } else if !rules.said_by_a_belt(group) {
            rules.tables(group.table).iter().for_each(|path| rules.exclusive(group, path));
        }
    }
    rules.contact();
    rules.webbing();
    rules.carriage();
    match rules.kind {
        Some(Kind::Driven) => {
            rules.driven();
            rules.motor();
            rules.dring();
        }
        Some(Kind::Excited) => {
            rules.excited();
            rules.integrator();
            rules.angle();
        }
        None => {}
    }
    rules.converters();
    rules.belt();
    rules.drive();
    rules.tracking();
    rules.burst();
    rules.friction_switch();
    rules.disturbances();
    rules.heat();
    rules.profiles();
    rules.overlays();
    rules.faults();
    rules.trace();
    rules.expectations();
    rules.axes();
    rules.comparison();
    rules.variations();
    // The last five judge a scene in which nothing else is wrong: first this one, then what is made of it.
    rules.replaced();
    rules.firmware();
    rules.cells();
    rules.cases();
    rules.ends();
    rules.findings
}

struct Rules<'a> {
    root: &'a Node,
    findings: Findings,
    /// What kind of scene it is, if that can be said.
    kind: Option<Kind>,
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

    /// The path to point at, of two whose values contradict each other: that of the newer text, or else the first.
    fn newer<'p>(&self, path: &'p str, other: &'p str) -> &'p str {
        if self.given(other) && self.place(other).source < self.place(path).source { other } else { path }
    }

    fn add(&mut self, path: &str, problem: Problem) {
        self.findings.add(path, problem);
    }

    fn expectations(&mut self) {
        for path in self.tables("expect") {
            self.metric(&join(&path, "metric"));
            self.of_a_case(&path);
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
        let Some(name) = self.text(path).filter(|name| !metrics::is_known(name)) else { return };
        if metrics::machine_figure(name).is_some() {
            let message = format!("`{name}` is a figure of the machine, and differs from run to run");
            let problem = Problem::new(self.place(path), message, "no metric");
            self.add(path, problem.help("it stands in `machine.json`, and in `machine` of `--format json`"));
            return;
        }
        let meant = nearest(name, metrics::names());
        let label = meant.first().map_or("not measured".to_owned(), |meant| format!("did you mean `{meant}`?"));
        let problem = Problem::new(self.place(path), format!("there is no metric `{}`", short(name)), label);
        self.add(path, problem.help("`sim-host explain` lists all metrics; of several runs also with `_p95` or `_max` behind"));
    }
}
