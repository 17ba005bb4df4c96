//! The method of a contact study: whether it is made for the contact and the rig, and which orders it has.

use super::Rules;
use crate::diagnostic::Problem;
use crate::nearest::listed;
use contact::{linexp, taylor};

const METHOD: &str = "integrator.method";
const ORDER: &str = "integrator.order";
const TOLERANCE_OF: &str = "integrator.tolerance_of";

impl Rules<'_> {
    pub(super) fn integrator(&mut self) {
        let Some(method) = (if self.given(METHOD) { self.text(METHOD) } else { Some("auto") }) else { return };
        self.suited(method);
        self.has_record(method);
        let orders: &[u32] = match method {
            "auto" | "linexp" | "frozen" => &linexp::ORDERS,
            "taylor" => &taylor::ORDERS,
            _ => &[],
        };
        let Some(order) = self.root.at(ORDER).and_then(|_| self.number(ORDER)) else { return };
        if orders.iter().any(|known| f64::from(*known) == order) {
            return;
        }
        let names: Vec<String> = orders.iter().map(u32::to_string).collect();
        let (label, help) = match names.as_slice() {
            [] => ("leave it out".to_owned(), "linexp and taylor have a choice of orders".to_owned()),
            _ => (
                format!("{method} has none of order {order}"),
                format!("its orders are {}", listed(names.iter().map(String::as_str), "and")),
            ),
        };
        let message =
            if orders.is_empty() { format!("{method} has no choice of order") } else { format!("there is no order {order}") };
        let problem = Problem::new(self.place(ORDER), message, label);
        self.add(ORDER, problem.help(help));
    }

    /// A tolerance of the record needs a record: states from the start of the run on, in steps that can be made shorter.
    fn has_record(&mut self, method: &str) {
        if !self.given(TOLERANCE_OF) || self.text(TOLERANCE_OF) != Some("record") {
            return;
        }
        let (reason, help) = match method {
            _ if self.given("contact.hertz") => (
                "vibration across a Hertzian contact has a tolerance of its mean only",
                "leave `integrator.tolerance_of` out: then `error_estimate` is of the mean friction ratio",
            ),
            _ if self.given("contact.compliant") => (
                "a compliant contact under vibration across it has one steady period, not a run from its start on",
                "leave `integrator.tolerance_of` out: then `error_estimate` is of the mean friction ratio",
            ),
            "closed" => (
                "the closed form is one steady period, not a run from its start on",
                "leave `integrator.method` out: auto takes a method with steps, whose record it compares",
            ),
            _ => return,
        };
        let problem = Problem::new(self.place(TOLERANCE_OF), "there is no record to have a tolerance", reason);
        self.add(TOLERANCE_OF, problem.help(help));
    }

    /// A method that is asked for by name must be made for the contact.
    fn suited(&mut self, method: &str) {
        // A vibration at an angle to the sliding has methods of its own, and a rule for them.
        if self.number("excitation.angle_deg").is_some_and(|angle| angle != 0.0) {
            return;
        }
        let has = |path: &str| self.given(path);
        let reason = match method {
            "linexp" | "frozen" | "closed" if has("contact.lugre") => "LuGre friction is for taylor, rk4-events and midpoint",
            "frozen" | "taylor" | "rk4" | "rk4-events" | "midpoint" if has("contact.coulomb") => {
                "Coulomb friction jumps at every reversal: linexp follows it exactly"
            }
            "closed" if has("rig.sdof") => "an oscillator has no closed form here",
            "frozen" if has("rig.kinematic") => "a given motion is frozen already: take linexp",
            other if has("contact.hertz") && has("rig.sdof") && !["auto", "rk4-events"].contains(&other) => {
                "a mass on a Hertzian contact is followed from one loss of contact to the next: rk4-events"
            }
            other if has("contact.hertz") && !has("rig.sdof") && !["auto", "closed"].contains(&other) => {
                "a Hertzian contact has its closed form only"
            }
            other if has("contact.compliant") && !has("rig.sdof") && !["auto", "closed"].contains(&other) => {
                "a compliant contact under vibration across it is solved by its arcs, without steps"
            }
            _ => return,
        };
        let problem = Problem::new(self.place(METHOD), format!("{method} cannot do this"), reason);
        self.add(
            METHOD,
            problem.help("leave `integrator.method` out: auto takes the cheapest that meets the tolerance, and says why"),
        );
    }
}
