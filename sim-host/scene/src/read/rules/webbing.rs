//! A belt under a horn: its contact, its amplitude and its trigger.

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
    /// Whether a belt says what one of these keys would.
    pub(super) fn said_by_a_belt(&self, group: &Exclusive) -> bool {
        group.table == "controller.drive" && self.given(BELT) && !self.given(AMPLITUDE) && !self.given(VELOCITY)
    }

    pub(super) fn webbing(&mut self) {
        if self.given("stator") || self.kind == Some(Kind::Excited) {
            return;
        }
        self.pair();
        if !self.given(BELT) {
            return;
        }
        for key in [AMPLITUDE, VELOCITY] {
            if self.value(key).is_some() {
                let message = format!("`{key}` has no place beside [{BELT}]");
                let problem = Problem::new(self.key(key), message, format!("`{AMPLITUDE_FRACTION}` says it"));
                self.add(key, problem.help("the controller holds the amplitude of the horn: 1 is the full one, 0.7 is 70 %"));
            }
        }
        if self.number(DELAY).is_some_and(|delay_s| delay_s > 0.0) && self.value(PERIOD).is_some() {
            let message = "a trigger delay moves listed windows, and this burst repeats";
            let at = self.newer(DELAY, PERIOD);
            let problem = Problem::new(self.key(at), message, "needs `on_s` and `off_s`, or a `trigger_delay_s` of 0");
            self.add(at, problem.help("a repeated burst is triggered once, and has no further trigger to be late after"));
        }
    }

    /// The law of a belt and the belt need each other, whatever else there is in their place.
    fn pair(&mut self) {
        let others = |table: &str, own: &str| {
            let tables = self.root.at(table).and_then(|node| node.table());
            let keys = tables.into_iter().flat_map(|table| table.keys()).map(|key| join(table, key));
            keys.filter(|path| path != own && self.clean(path)).collect::<Vec<_>>()
        };
        let of_belt = "a belt under a horn rubs by a fitted law, which has defaults for all its constants: [contact.empirical]";
        let of_law = "this law is fitted to a belt under a horn, which vibrates across it; along a sliding tip the contact is [contact.dahl]";
        let wrong = match (self.given(BELT), self.given(EMPIRICAL)) {
            (true, false) => others("contact", EMPIRICAL).into_iter().map(|path| (path, BELT, EMPIRICAL, of_belt)).collect(),
            (false, true) => others("rig", BELT).into_iter().map(|path| (path, EMPIRICAL, BELT, of_law)).collect(),
            _ => Vec::new(),
        };
        for (path, with, needed, help) in wrong {
            let message = format!("[{with}] and {} do not go together", header(&path));
            let problem = Problem::new(self.key(&path), message, format!("[{with}] needs [{needed}]"));
            self.add(&path, problem.help(help));
        }
    }
}
