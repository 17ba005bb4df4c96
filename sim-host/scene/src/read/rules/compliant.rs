//! Rules of a compliant contact under vibration across it: supported rigs, waveforms and loads.

use super::Rules;
use crate::diagnostic::Problem;

const COMPLIANT: &str = "contact.compliant";
const RIG: &str = "rig.sdof";
const WAVEFORM: &str = "excitation.waveform";

impl Rules<'_> {
    /// Checks for a prescribed sine and a constant load.
    pub(super) fn compliant(&mut self) {
        if !self.given(COMPLIANT) {
            return;
        }
        if self.given(RIG) {
            let message = "the vibration of a compliant contact must be prescribed, but that of [rig.sdof] is not";
            let problem = Problem::new(self.key(RIG), message, "must be [rig.kinematic] with [contact.compliant]");
            self.add(RIG, problem.help("for a mass that a force excites across the surface, use [contact.hertz]"));
        }
        if self.text(WAVEFORM).is_some_and(|waveform| waveform != "sine") {
            let message = "a compliant contact supports only a sine";
            let problem = Problem::new(self.place(WAVEFORM), message, "must be `sine` with [contact.compliant]");
            self.add(WAVEFORM, problem);
        }
        for path in self.tables("disturbance") {
            let message = "a compliant contact supports only a constant load";
            let problem = Problem::new(self.place(&path), message, "not with [contact.compliant]");
            self.add(&path, problem);
        }
    }
}
