//! Rules of a belt under a horn: its contact, amplitude and trigger.

use super::Rules;
use super::drive::{AMPLITUDE, AMPLITUDE_FRACTION, VELOCITY};
use super::kind::{BELT, EMPIRICAL, Kind};
use crate::diagnostic::Problem;
use crate::exclusive::Exclusive;
use crate::schema::join;
use crate::wording::header;

const DELAY: &str = "rig.belt.trigger_delay_s";
const PERIOD: &str = "controller.burst.period_s";

impl Rules<'_> {
    /// Returns `true` if a belt replaces the keys of this group.
    pub(super) fn replaced_by_belt(&self, group: &Exclusive) -> bool {
        group.table == "controller.drive" && self.given(BELT) && !self.given(AMPLITUDE) && !self.given(VELOCITY)
    }

    pub(super) fn webbing(&mut self) {
        if self.given("stator") || self.kind == Some(Kind::Excited) {
            return;
        }
        self.check_belt_pair();
        if !self.given(BELT) {
            return;
        }
        for key in [AMPLITUDE, VELOCITY] {
            if self.value(key).is_some() {
                let message = format!("`{key}` cannot be combined with [{BELT}]");
                let problem = Problem::new(self.key(key), message, format!("`{AMPLITUDE_FRACTION}` replaces it"));
                self.add(
                    key,
                    problem.help("the controller controls the amplitude of the horn: 1 is the full amplitude, 0.7 is 70 %"),
                );
            }
        }
        if self.number(DELAY).is_some_and(|delay_s| delay_s > 0.0) && self.value(PERIOD).is_some() {
            let message = "a trigger delay applies to listed windows, but this burst is periodic";
            let at = self.newer(DELAY, PERIOD);
            let problem = Problem::new(self.key(at), message, "needs `on_s` and `off_s`, or a `trigger_delay_s` of 0");
            self.add(at, problem.help("a periodic burst is triggered only once, so no further trigger can be delayed"));
        }
    }

    /// Checks that a belt and its law occur together, even if other tables are given instead.
    fn check_belt_pair(&mut self) {
        let others = |table: &str, own: &str| {
            let tables = self.root.at(table).and_then(|node| node.table());
            let keys = tables.into_iter().flat_map(|table| table.keys()).map(|key| join(table, key));
            keys.filter(|path| path != own && self.clean(path)).collect::<Vec<_>>()
        };
        let of_belt =
            "the friction of a belt under a horn follows a fitted law with defaults for all its constants: [contact.empirical]";
        let of_law = "this law is fitted to a belt under a horn, which vibrates across it; for a tip that vibrates along the \
                      motion, use [contact.dahl]";
        let wrong = match (self.given(BELT), self.given(EMPIRICAL)) {
            (true, false) => others("contact", EMPIRICAL).into_iter().map(|path| (path, BELT, EMPIRICAL, of_belt)).collect(),
            (false, true) => others("rig", BELT).into_iter().map(|path| (path, EMPIRICAL, BELT, of_law)).collect(),
            _ => Vec::new(),
        };
        for (path, with, needed, help) in wrong {
            let message = format!("[{with}] and {} cannot be combined", header(&path));
            let problem = Problem::new(self.key(&path), message, format!("[{with}] needs [{needed}]"));
            self.add(&path, problem.help(help));
        }
    }
}
