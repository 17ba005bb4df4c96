//! Rules of a motor: a stator replaces the stack, a rotor needs a stator, and only a stator has
//! lane errors.

use super::Rules;
use crate::diagnostic::Problem;
use crate::schema::join;
use crate::wording::header;

const STACK: &str = "stack";
const STATOR: &str = "stator";
const ROTOR: &str = "rig.rotor";
/// Faults that only a stack can have.
const STACK_FAULTS: [&str; 3] = ["short", "depoled", "cracked"];

impl Rules<'_> {
    pub(super) fn motor(&mut self) {
        if self.given(STACK) && self.given(STATOR) {
            let (one, other) = (self.key(STACK), self.key(STATOR));
            let (later, earlier) = if one < other { (other, STACK) } else { (one, STATOR) };
            let message = "[stack] and [stator] exclude each other";
            let problem = Problem::new(later, message, format!("{} is already given", header(earlier)));
            self.add(STATOR, problem.help("the firmware drives a stack, or the stator of a motor"));
            return;
        }
        if self.given(STATOR) {
            for table in ["contact", "rig.slider", "rig.belt", "rig.dring", "rig.carriage"]
                .into_iter()
                .filter(|table| self.given(table))
                .collect::<Vec<_>>()
            {
                let message = format!("{} cannot be combined with [stator]", header(table));
                let problem = Problem::new(self.key(table), message, "belongs to [stack]");
                self.add(table, problem.help("a stator moves [rig.rotor], whose keys include its contact"));
            }
            self.check_stack_only_keys();
            return;
        }
        if self.given(ROTOR) && self.lacks(STATOR) {
            let problem = Problem::new(self.key(ROTOR), "[rig.rotor] without [stator]", "needs [stator]");
            self.add(ROTOR, problem.help("a rotor turns on the wave of a stator"));
        }
        for key in ["amplifier.lane_phase_error_deg", "amplifier.lane_gain_error"] {
            if self.value(key).is_some_and(|list| !list.list().is_empty()) && self.given(STACK) {
                let problem =
                    Problem::new(self.key(key), format!("`{key}` cannot be combined with [stack]"), "belongs to [stator]");
                self.add(key, problem.help("a stack uses only the first lane, so lanes cannot differ"));
            }
        }
    }

    /// Reports keys and faults that only a stack has, in a scene with a stator.
    fn check_stack_only_keys(&mut self) {
        let delay = "amplifier.delay_s";
        if self.number(delay).is_some_and(|delay_s| delay_s != 0.0) {
            let problem =
                Problem::new(self.key(delay), format!("`{delay}` cannot be combined with [stator]"), "belongs to [stack]");
            self.add(delay, problem.help("the delay of a stator's lanes is `amplifier.lane_phase_error_deg`"));
        }
        for kind in self.tables("fault").into_iter().map(|path| join(&path, "kind")).collect::<Vec<_>>() {
            if let Some(broken) = self.text(&kind).filter(|broken| STACK_FAULTS.contains(broken)) {
                let message = format!("a stator cannot have the fault `{broken}`");
                let problem = Problem::new(self.place(&kind), message, "only for a [stack]");
                self.add(&kind, problem.help("this fault of a stator is not simulated"));
            }
        }
    }
}
