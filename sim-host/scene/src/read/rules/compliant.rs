//! A compliant contact under vibration across it: which rigs, waveforms and courses it has a solution for.

use super::Rules;
use crate::diagnostic::Problem;

const COMPLIANT: &str = "contact.compliant";
const RIG: &str = "rig.sdof";
const WAVEFORM: &str = "excitation.waveform";

impl Rules<'_> {
    /// It has a solution for a sine that is given, under one load.
    pub(super) fn compliant(&mut self) {
        if !self.given(COMPLIANT) {
            return;
        }
        if self.given(RIG) {
            let message = "the vibration of a compliant contact is given, and [rig.sdof] has none that is";
            let problem = Problem::new(self.key(RIG), message, "must be [rig.kinematic] with [contact.compliant]");
            self.add(RIG, problem.help("a mass that a force shakes across the surface lies on [contact.hertz]"));
        }
        if self.text(WAVEFORM).is_some_and(|waveform| waveform != "sine") {
            let message = "a compliant contact is studied under a sine only";
            let problem = Problem::new(self.place(WAVEFORM), message, "must be `sine` with [contact.compliant]");
            self.add(WAVEFORM, problem);
        }
        for path in self.tables("disturbance") {
            let message = "a compliant contact is studied under one load only";
            let problem = Problem::new(self.place(&path), message, "not with [contact.compliant]");
            self.add(&path, problem);
        }
    }
}
