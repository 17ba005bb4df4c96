//! A D-ring: it has its own contact, and the restraint that decides on it measures the belt's force.

use super::{Rules, shown};
use crate::diagnostic::Problem;
use crate::wording::header;

const DRING: &str = "rig.dring";
const RESTRAINT: &str = "controller.restraint";
const FORCE: &str = "sensors.force_hz";

impl Rules<'_> {
    pub(super) fn dring(&mut self) {
        self.restraint();
        if !self.given(DRING) {
            return;
        }
        if self.given("contact") {
            let problem = Problem::new(self.key("contact"), "[contact] has no place beside [rig.dring]", "the D-ring is one");
            self.add("contact", problem.help("its friction is `rig.dring.mu_high`, `mu_low` and what `actuator` does"));
        }
        let (low, high) = ("rig.dring.mu_low", "rig.dring.mu_high");
        if let (Some(mu_low), Some(mu_high)) = (self.number(low), self.number(high))
            && mu_low > mu_high
        {
            let at = self.newer(low, high);
            let message = format!("low friction of {} is more than high friction of {}", shown(mu_low), shown(mu_high));
            let problem = Problem::new(self.place(at), message, "`mu_low` must be at most `mu_high`");
            self.add(at, problem);
        }
        let at_s = "rig.dring.at_s";
        if let Some(time) = self.number(at_s) {
            self.within_the_run(at_s, time);
        }
    }

    fn restraint(&mut self) {
        if !self.given(RESTRAINT) {
            return;
        }
        let missing =
            [(DRING, "a restraint decides on the friction of a D-ring"), (FORCE, "it senses the crash by the force in the belt")];
        for (path, why) in missing {
            if self.lacks(path) {
                let called = if path == DRING { header(path) } else { format!("`{path}`") };
                let message = format!("{} without {called}", header(RESTRAINT));
                let problem = Problem::new(self.key(RESTRAINT), message, format!("needs {called}"));
                self.add(path, problem.help(why));
            }
        }
        if self.given("controller.burst") {
            let message = "[controller.burst] and [controller.restraint] exclude each other";
            let problem = Problem::new(self.key("controller.burst"), message, "the restraint says when the drive is ON");
            self.add("controller.burst", problem);
        }
    }
}
