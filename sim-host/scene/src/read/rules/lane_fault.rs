//! Rules of the keys of each kind of fault, and of the lanes of a stator.

use super::Rules;
use crate::diagnostic::Problem;
use crate::schema::join;

const LANES: &str = "controller.drive.lanes";
const OPEN: &str = "lane_open";
const WEAK: &str = "lane_weak";
const REVERSED: &str = "lane_reversed";
const EXCHANGED: &str = "lanes_exchanged";
/// Keys of such faults, and the kinds they belong to.
const KEYS: [(&str, &[&str]); 4] =
    [("lane", &[OPEN, WEAK, REVERSED, EXCHANGED]), ("other_lane", &[EXCHANGED]), ("gain", &[WEAK]), ("ohm", &["short"])];

impl Rules<'_> {
    /// Checks a fault of a lane: it needs a stator and its lane. Other faults must not have these
    /// keys.
    pub(super) fn check_lane_fault(&mut self, path: &str) {
        let kind = join(path, "kind");
        let Some(of) = self.text(&kind) else { return };
        for (key, kinds) in KEYS {
            let key = join(path, key);
            if self.value(&key).is_some() && !kinds.contains(&of) {
                let problem =
                    Problem::new(self.key(&key), format!("`{key}` cannot be used with the fault `{of}`"), "not for this kind");
                self.add(&key, problem.help(format!("it belongs to {}", kinds.join(", "))));
            } else if key.ends_with("lane") && kinds.contains(&of) && !self.given(&key) {
                let problem = Problem::new(self.place(&kind), format!("the fault `{of}` needs `{key}`"), "which lane?");
                self.add(&kind, problem.help("lanes are counted from 0"));
            }
        }
        if !KEYS[0].1.contains(&of) {
            return;
        }
        if self.lacks("stator") {
            let problem =
                Problem::new(self.place(&kind), format!("a scene without [stator] cannot have `{of}`"), "needs [stator]");
            self.add(&kind, problem.help("a stack uses only the first lane"));
            return;
        }
        let (lane, other) = (join(path, "lane"), join(path, "other_lane"));
        let count = self.number(LANES).unwrap_or(1.0);
        for key in [&lane, &other] {
            if let Some(number) = self.number(key).filter(|number| *number >= count) {
                let problem =
                    Problem::new(self.place(key), format!("there is no lane {number}"), format!("must be less than {count}"));
                self.add(key, problem.help(format!("`{LANES}` is {count}, and lanes are counted from 0")));
            }
        }
        if let (Some(one), Some(two)) = (self.number(&lane), self.number(&other))
            && one == two
        {
            let problem = Problem::new(self.place(&other), "a lane is exchanged with itself", "must be another lane");
            self.add(&other, problem);
        }
    }
}
