//! Rules of times: bursts, faults and the recorded part.

use super::Rules;
use crate::diagnostic::Problem;
use crate::schema::join;

const BURST: &str = "controller.burst";

impl Rules<'_> {
    pub(super) fn burst(&mut self) {
        let (on_s, off_s) = (join(BURST, "on_s"), join(BURST, "off_s"));
        if !self.given(&on_s) || !self.given(&off_s) {
            return;
        }
        let (Some(on), Some(off)) = (self.numbers(&on_s), self.numbers(&off_s)) else { return };
        if on.is_empty() || on.len() != off.len() {
            let message = format!("`on_s` has length {}, `off_s` has length {}", on.len(), off.len());
            let label = if on.is_empty() { "needs at least one of each" } else { "needs as many values as `on_s`" };
            let problem = Problem::new(self.place(&off_s), message, label);
            return self.add(&off_s, problem);
        }
        let mut before = None;
        for (index, (&on, &off)) in on.iter().zip(&off).enumerate() {
            let (begins, ends) = (format!("{on_s}.{index}"), format!("{off_s}.{index}"));
            if off <= on {
                let message = format!("this window ends at {off} s, but begins at {on} s");
                let problem = Problem::new(self.place(&ends), message, format!("must be after {on} s"));
                self.add(&ends, problem);
            }
            if let Some(before) = before.filter(|before| on <= *before) {
                let message = format!("this window begins at {on} s, but the one before ends at {before} s");
                let problem = Problem::new(self.place(&begins), message, format!("must be after {before} s"));
                self.add(&begins, problem.help("windows must be in order of time, with gaps between them"));
            }
            self.within_the_run(&begins, on);
            before = Some(off);
        }
    }

    pub(super) fn faults(&mut self) {
        for path in self.tables("fault") {
            let at_s = join(&path, "at_s");
            if let Some(time) = self.number(&at_s) {
                self.within_the_run(&at_s, time);
            }
            self.check_lane_fault(&path);
        }
    }

    pub(super) fn trace(&mut self) {
        let Some(from) = self.number("trace.from_s") else { return };
        self.within_the_run("trace.from_s", from);
        if let Some(to) = self.number("trace.to_s").filter(|to| *to <= from) {
            let message = format!("the trace ends at {to} s, but begins at {from} s");
            let problem = Problem::new(self.place("trace.to_s"), message, format!("must be after {from} s"));
            self.add("trace.to_s", problem);
        }
    }

    pub(super) fn within_the_run(&mut self, path: &str, at_s: f64) {
        let Some(duration) = self.number("duration_s").filter(|duration| at_s >= *duration) else { return };
        let message = format!("`{path}` is {at_s} s, but the run ends at {duration} s");
        let at = self.newer(path, "duration_s");
        let label = if at == path { format!("must be less than {duration} s") } else { format!("must be more than {at_s} s") };
        let problem = Problem::new(self.place(at), message, label);
        self.add(path, problem.help(format!("`duration_s` is {duration}")));
    }
}
