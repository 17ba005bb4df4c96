//! The rule for circuit values: the set must be complete and consistent.

use std::f64::consts::TAU;

use super::Rules;
use crate::circuit::{CircuitError, Given};
use crate::diagnostic::Problem;
use crate::exclusive::Exclusive;
use crate::nearest::shown;
use crate::schema::{Schema, join};
use crate::tree::{Entry, Node, Value};
use crate::wording::{range, within};

const TABLE: &str = "stack.bvd";
/// Keys of a circuit, except its clamped capacitance.
const KEYS: [&str; 7] = ["cm_f", "lm_h", "rm_ohm", "series_resonance_hz", "parallel_resonance_hz", "q", "coupling"];
/// Sets of keys that the rest of the program accepts.
const FORMS: [[&str; 3]; 2] = [["cm_f", "lm_h", "rm_ohm"], ["series_resonance_hz", "q", "coupling"]];

/// Returns the values that a scene gives.
fn given(root: &Node) -> Given {
    let number = |key: &str| root.at(&join(TABLE, key)).and_then(Node::number);
    Given {
        c0_f: number("c0_f"),
        ct_f: number("ct_f").map(|ct_f| ct_f - further_capacitance(root)),
        cm_f: number("cm_f"),
        lm_h: number("lm_h"),
        rm_ohm: number("rm_ohm"),
        series_resonance_hz: number("series_resonance_hz"),
        parallel_resonance_hz: number("parallel_resonance_hz"),
        q: number("q"),
        coupling: number("coupling"),
    }
}

/// Returns the sum of the motional capacitances of the further modes, F.
fn further_capacitance(root: &Node) -> f64 {
    let modes = root.at("stack.mode").map_or(&[][..], Node::list);
    let capacitance = |mode: &Node| {
        let number = |key: &str| mode.at(key).and_then(Node::number);
        Some(1.0 / ((TAU * number("series_resonance_hz")?).powi(2) * number("lm_h")?))
    };
    modes.iter().filter_map(capacitance).sum()
}

/// Replaces `ct_f` by the clamped capacitance, if the circuit is complete and does not give `c0_f`.
pub(crate) fn clamped(root: &mut Node) {
    let (Some(ct_f), Ok(elements)) = (root.at("stack.bvd.ct_f").cloned(), given(root).resolve()) else { return };
    let Some(Value::Table(table)) = root.at_mut(TABLE).map(|node| &mut node.value) else { return };
    if table.contains_key("c0_f") {
        return;
    }
    table.remove("ct_f");
    let node = Node { place: ct_f.place.clone(), value: Value::Number(elements.c0_f) };
    table.insert("c0_f".to_owned(), Entry { key: ct_f.place, node });
}

/// Returns the keys that a scene gives.
fn keys(root: &Node) -> Vec<&'static str> {
    KEYS.into_iter().filter(|key| root.at(&join(TABLE, key)).is_some()).collect()
}

/// Replaces any other complete set by series resonance, Q and coupling. An incomplete set is not
/// changed; the rules report it.
pub(crate) fn complete(root: &mut Node) {
    let present = keys(root);
    if FORMS.iter().any(|form| form[..] == present[..] || present.iter().all(|key| form.contains(key))) {
        return;
    }
    let Ok(elements) = given(root).resolve() else { return };
    let Some(Value::Table(stack)) = root.entry_mut("stack").map(|node| &mut node.value) else { return };
    let Some(Value::Table(table)) = stack.get_mut("bvd").map(|entry| &mut entry.node.value) else { return };
    let Some((key, place)) =
        present.first().and_then(|key| table.get(*key)).map(|entry| (entry.key.clone(), entry.node.place.clone()))
    else {
        return;
    };
    let values =
        [("series_resonance_hz", elements.series_resonance_hz()), ("q", elements.q()), ("coupling", elements.coupling())];
    KEYS.iter().filter(|key| !FORMS[1].contains(key)).for_each(|key| drop(table.remove(*key)));
    for (name, value) in values {
        // Given values are not replaced.
        let new = Entry { key: key.clone(), node: Node { place: place.clone(), value: Value::Number(value) } };
        table.entry(name.to_owned()).or_insert(new);
    }
}

impl Rules<'_> {
    /// Checks `ct_f`: the clamped capacitance must follow from it, and must not contradict `c0_f`.
    fn check_total(&mut self) {
        let (path, clamped) = (join(TABLE, "ct_f"), join(TABLE, "c0_f"));
        if !self.given(&path) || !self.clean(&path) {
            return;
        }
        if let Err(error) = given(self.root).resolve() {
            let problem = Problem::new(self.key(&path), error.to_string(), "in this circuit");
            // The missing `c0_f` is the same mistake.
            self.findings.problems.retain(|problem| problem.message != format!("`c0_f` is missing {}", within(TABLE)));
            let help = "`ct_f` replaces `c0_f`: it is the capacitance of the clamped and motional branches together";
            self.findings.problems.push(problem.help(help));
            [path, clamped].into_iter().for_each(|key| self.findings.mark(key));
        }
    }

    /// Checks a set that is not one of the two usual forms. The usual forms are checked by the rule
    /// for exclusive keys.
    pub(super) fn circuit(&mut self, group: &Exclusive) {
        self.check_total();
        let present = keys(self.root);
        let usual = FORMS.iter().any(|form| present.iter().all(|key| form.contains(key)));
        let sound = KEYS.iter().chain(&["c0_f"]).all(|key| self.clean(&join(TABLE, key)));
        let error = given(self.root).resolve().err();
        match (usual, error) {
            (false, Some(CircuitError::Incomplete(_))) if present.contains(&"q") && present.contains(&"rm_ohm") => {
                self.exclusive(group, TABLE);
            }
            (false, Some(error)) if sound && self.root.at(TABLE).is_some() => {
                let first = match &error {
                    CircuitError::Contradicting { name, .. } => Some(*name),
                    CircuitError::Incomplete(_) => present.first().copied(),
                };
                let key = first.map_or_else(|| TABLE.to_owned(), |key| join(TABLE, key));
                let problem = Problem::new(self.key(&key), error.to_string(), "in this circuit");
                let help = "in addition to `c0_f`, give `q` or `rm_ohm`, and two of `series_resonance_hz`, \
                            `parallel_resonance_hz`, `lm_h`, and (`cm_f` or `coupling`)";
                self.findings.problems.push(problem.help(help));
                present.iter().for_each(|key| self.findings.mark(join(TABLE, key)));
            }
            (true, _) => {
                self.exclusive(group, TABLE);
                if sound {
                    self.check_derived();
                }
            }
            _ => {}
        }
    }

    /// Checks that the values that have replaced another set are within their ranges.
    fn check_derived(&mut self) {
        for key in FORMS[1] {
            let path = join(TABLE, key);
            let Some((value, schema)) = self.number(&path).zip(Schema::root().at(&path)) else { continue };
            let limits = schema.range();
            if limits.0.is_some_and(|least| value < least) || limits.1.is_some_and(|most| value > most) {
                let message = format!("`{key}` follows as {}, which is out of range", shown(value));
                let problem = Problem::new(self.key(&path), message, format!("it must be {}", range(limits, &path)));
                self.add(&path, problem.help("the numbers of the circuit contradict each other, or one has another unit"));
            }
        }
    }
}
