//! Rules that a schema cannot express: dependencies between the keys of a scene.
//!
//! A rule is skipped if one of its keys is already known to be wrong. Thus one mistake neither
//! causes a second message nor hides another mistake.

mod angle;
mod belt;
mod carriage;
mod cells;
pub(crate) mod circuit;
mod comparison;
mod compliant;
mod contact;
mod converters;
mod design;
mod disturbance;
mod dring;
mod drive;
mod excitation;
mod exclusive;
mod expression;
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

pub(crate) use cells::remove_non_cell_keys;
use kind::Kind;
pub(crate) use kind::two_kinds;

/// Checks a scene that has been walked, and adds to the findings of the walk.
pub(crate) fn check(root: &Node, findings: Findings) -> Findings {
    let mut rules = Rules { root, findings, kind: None };
    rules.kind();
    rules.check_tables();
    for group in EXCLUSIVE {
        if group.table == "stack.bvd" {
            rules.circuit(group);
        } else if !rules.replaced_by_belt(group) {
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
        Some(Kind::Designed) => rules.designed(),
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
    // The last five check only a scene without other problems: first the scene itself, then the
    // scenes derived from it.
    rules.replaced();
    rules.firmware();
    rules.check_first_cell();
    rules.check_cases();
    rules.check_ends();
    rules.findings
}

struct Rules<'a> {
    root: &'a Node,
    findings: Findings,
    /// Kind of the scene, if it is known.
    kind: Option<Kind>,
}

impl<'a> Rules<'a> {
    /// Returns `true` if a value, or its absence, has no problem. An absent value that is given
    /// under another name has one.
    fn clean(&self, path: &str) -> bool {
        self.findings.clean(path) && (self.given(path) || !self.findings.meant(path))
    }

    fn given(&self, path: &str) -> bool {
        self.root.at(path).is_some()
    }

    /// Returns `true` if nothing is given at a path, under this name or another.
    fn lacks(&self, path: &str) -> bool {
        !self.given(path) && self.clean(path)
    }

    /// Returns the value at a path, if it is given and valid.
    fn value(&self, path: &str) -> Option<&'a Node> {
        self.root.at(path).filter(|_| self.clean(path))
    }

    /// Returns a number of the scene, or its default, if it is valid.
    fn number(&self, path: &str) -> Option<f64> {
        match self.root.at(path) {
            Some(_) => self.value(path)?.number(),
            None => self.default(path)?.as_f64(),
        }
    }

    /// Returns a string of the scene, or its default, if it is valid.
    fn text(&self, path: &str) -> Option<&'a str> {
        match self.root.at(path) {
            Some(_) => self.value(path)?.text(),
            None => self.default(path)?.as_str(),
        }
    }

    /// Returns a list of numbers, if it is valid; an absent list is empty.
    fn numbers(&self, path: &str) -> Option<Vec<f64>> {
        self.clean(path).then(|| self.root.at(path).into_iter().flat_map(Node::list).filter_map(Node::number).collect())
    }

    fn default(&self, path: &str) -> Option<&'static serde_json::Value> {
        Schema::root().at(path).filter(|_| self.clean(path))?.default()
    }

    /// Returns the paths of the tables at a path: of a table itself, or of the entries of a list.
    fn tables(&self, path: &str) -> Vec<String> {
        let Some(node) = self.root.at(path) else { return Vec::new() };
        if node.table().is_some() {
            return vec![path.to_owned()];
        }
        (0..node.list().len()).map(|index| join(path, &index.to_string())).collect()
    }

    /// Returns the place of a value, or of the innermost table that would contain it.
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

    /// Returns the place of a key.
    fn key(&self, path: &str) -> Place {
        self.root.entry(path).map_or_else(|| self.place(path), |entry| entry.key.clone())
    }

    /// Returns the path to mark if two values contradict each other: that of the newer text, or
    /// else the first.
    fn newer<'p>(&self, path: &'p str, other: &'p str) -> &'p str {
        if self.given(other) && self.place(other).source < self.place(path).source { other } else { path }
    }

    fn add(&mut self, path: &str, problem: Problem) {
        self.findings.add(path, problem);
    }

    fn expectations(&mut self) {
        for path in self.tables("expect") {
            self.metric(&join(&path, "metric"));
            self.check_case(&path);
            let (least, most) = (join(&path, "min"), join(&path, "max"));
            if let (Some(min), Some(max)) = (self.number(&least), self.number(&most))
                && min > max
            {
                let message = format!("no value is at least {} and at most {}", shown(min), shown(max));
                let place = self.place(self.newer(&most, &least));
                let problem = Problem::new(place, message, "`max` is less than `min`");
                self.add(&most, problem);
            }
        }
    }

    fn metric(&mut self, path: &str) {
        let Some(name) = self.text(path).filter(|name| !metrics::is_known(name)) else { return };
        if metrics::machine_figure(name).is_some() {
            let message = format!("`{name}` depends on the machine, and differs from run to run");
            let problem = Problem::new(self.place(path), message, "not a metric");
            self.add(path, problem.help("it is written to `machine.json`, and to `machine` of `--format json`"));
            return;
        }
        let meant = nearest(name, metrics::names());
        let label = meant.first().map_or("not measured".to_owned(), |meant| format!("did you mean `{meant}`?"));
        let problem = Problem::new(self.place(path), format!("there is no metric `{}`", short(name)), label);
        self.add(
            path,
            problem.help("`sim-host explain` lists all metrics; over several runs, append `_p95`, `_max`, `_low95` or `_high95`"),
        );
    }
}
