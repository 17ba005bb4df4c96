//! What happens when: bursts, disturbances, faults, and the part that is recorded.

use super::Rules;
use crate::scene::diagnostic::Problem;
use crate::scene::schema::{Schema, join};
use crate::scene::tree::{Node, Value};
use crate::scene::walk::wrong_number;
use crate::scene::{Burst, Disturbance, Fault, Trace};

const BURST: &str = "controller.burst";

impl Rules<'_> {
    pub(super) fn burst(&mut self) {
        let Some(burst) = self.present::<Burst>(BURST) else { return };
        if burst.period_s.is_some() {
            return;
        }
        let (on, off) = (&burst.on_s, &burst.off_s);
        if on.is_empty() || on.len() != off.len() {
            let message = format!("the burst has {} beginnings and {} ends", on.len(), off.len());
            let label = if on.is_empty() { "needs at least one of each" } else { "needs as many as `on_s`" };
            let problem = Problem::new(self.place(&join(BURST, "off_s")), message, label);
            return self.add(BURST, problem);
        }
        let mut before = None;
        for (index, (&on, &off)) in on.iter().zip(off).enumerate() {
            let (begins, ends) = (format!("{BURST}.on_s.{index}"), format!("{BURST}.off_s.{index}"));
            if off <= on {
                let message = format!("this window ends at {off} s, but begins at {on} s only");
                let problem = Problem::new(self.place(&ends), message, format!("must be after {on} s"));
                self.add(&ends, problem);
            }
            if let Some(before) = before.filter(|before| on <= *before) {
                let message = format!("this window begins at {on} s, but the one before ends at {before} s only");
                let problem = Problem::new(self.place(&begins), message, format!("must be after {before} s"));
                self.add(&begins, problem.help("windows are in order of time and do not touch"));
            }
            self.within_the_run(&begins, on);
            before = Some(off);
        }
    }

    pub(super) fn disturbances(&mut self) {
        for path in self.tables("disturbance") {
            let Some(disturbance) = self.typed::<Disturbance>(&path) else { continue };
            self.within_the_run(&join(&path, "at_s"), disturbance.at_s);
            let key = join(&path, "key");
            let Some(target) = self.root.at(&key).and_then(Node::text) else { continue };
            let table = target.split('.').next().unwrap_or_default();
            if self.root.at(table).is_none() && self.findings.top_clean() {
                let message = format!("`{target}` cannot change: the scene has no [{table}]");
                let problem = Problem::new(self.place(&key), message, format!("needs [{table}]"));
                self.add(&key, problem);
            }
            let to = join(&path, "to");
            if let (Some(value), Some(schema)) = (disturbance.to, Schema::root().at(target)) {
                let node = Node { place: self.place(&to), value: Value::Number(value) };
                if let Some(problem) = wrong_number(&node, schema, target) {
                    self.add(&to, problem);
                }
            }
        }
    }

    pub(super) fn faults(&mut self) {
        for path in self.tables("fault") {
            if let Some(fault) = self.typed::<Fault>(&path) {
                self.within_the_run(&join(&path, "at_s"), fault.at_s);
            }
        }
    }

    pub(super) fn trace(&mut self) {
        let Some(trace) = self.present::<Trace>("trace") else { return };
        self.within_the_run("trace.from_s", trace.from_s);
        if let Some(to) = trace.to_s.filter(|to| *to <= trace.from_s) {
            let message = format!("the trace ends at {to} s, but begins at {} s only", trace.from_s);
            let problem = Problem::new(self.place("trace.to_s"), message, format!("must be after {} s", trace.from_s));
            self.add("trace.to_s", problem);
        }
    }

    fn within_the_run(&mut self, path: &str, at_s: f64) {
        let Some(duration) = self.number("duration_s").filter(|duration| at_s >= *duration) else { return };
        let message = format!("`{path}` is {at_s} s, but the run is over at {duration} s");
        let at = self.newer(path, "duration_s");
        let label = if at == path { format!("must be less than {duration} s") } else { format!("must be more than {at_s} s") };
        let problem = Problem::new(self.place(at), message, label);
        self.add(path, problem.help(format!("`duration_s` is {duration}")));
    }
}
