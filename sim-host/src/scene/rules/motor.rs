//! A motor: a stator stands instead of a stack, a rotor on a stator, and only a stator has lanes that differ.

use super::Rules;
use crate::scene::diagnostic::Problem;
use crate::scene::wording::header;

const STACK: &str = "stack";
const STATOR: &str = "stator";
const ROTOR: &str = "rig.rotor";

impl Rules<'_> {
    pub(super) fn motor(&mut self) {
        if self.given(STACK) && self.given(STATOR) {
            let (one, other) = (self.key(STACK), self.key(STATOR));
            let (later, earlier) = if one < other { (other, STACK) } else { (one, STATOR) };
            let message = "[stack] and [stator] exclude each other";
            let problem = Problem::new(later, message, format!("{} is given already", header(earlier)));
            self.add(STATOR, problem.help("the firmware drives a stack, or the stator of a motor"));
            return;
        }
        if self.given(STATOR) {
            for table in ["contact", "rig.slider"].into_iter().filter(|table| self.given(table)).collect::<Vec<_>>() {
                let message = format!("{} has no place beside [stator]", header(table));
                let problem = Problem::new(self.key(table), message, "belongs to [stack]");
                self.add(table, problem.help("what a stator moves is [rig.rotor], which has its contact in its own keys"));
            }
            return;
        }
        if self.given(ROTOR) && self.lacks(STATOR) {
            let problem = Problem::new(self.key(ROTOR), "[rig.rotor] without [stator]", "needs [stator]");
            self.add(ROTOR, problem.help("a rotor turns on the wave of a stator"));
        }
        for key in ["amplifier.lane_phase_error_deg", "amplifier.lane_gain_error"] {
            if self.value(key).is_some_and(|list| !list.list().is_empty()) && self.given(STACK) {
                let problem = Problem::new(self.key(key), format!("`{key}` has no place beside [stack]"), "belongs to [stator]");
                self.add(key, problem.help("a stack hangs on the first lane alone, so that no lane can differ from another"));
            }
        }
    }
}
