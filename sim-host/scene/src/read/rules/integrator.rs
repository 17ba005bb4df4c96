//! Rules of the integrator of a contact study: suitable method, order and tolerance.

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
        self.check_method(method);
        self.check_record(method);
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
            [] => ("omit it".to_owned(), "only linexp and taylor have a choice of orders".to_owned()),
            _ => (
                format!("{method} does not have order {order}"),
                format!("its orders are {}", listed(names.iter().map(String::as_str), "and")),
            ),
        };
        let message =
            if orders.is_empty() { format!("{method} has no choice of order") } else { format!("there is no order {order}") };
        let problem = Problem::new(self.place(ORDER), message, label);
        self.add(ORDER, problem.help(help));
    }

    /// Checks that a tolerance of the record has a record: states from the start of the run, in
    /// steps that can be refined.
    fn check_record(&mut self, method: &str) {
        if !self.given(TOLERANCE_OF) || self.text(TOLERANCE_OF) != Some("record") {
            return;
        }
        let (reason, help) = match method {
            _ if self.given("contact.hertz") => (
                "for vibration across a Hertzian contact, only the mean has a tolerance",
                "omit `integrator.tolerance_of`: `error_estimate` then refers to the mean friction ratio",
            ),
            _ if self.given("contact.compliant") => (
                "a compliant contact under vibration across it is solved for one steady period, not from the start",
                "omit `integrator.tolerance_of`: `error_estimate` then refers to the mean friction ratio",
            ),
            "closed" => (
                "the closed form gives one steady period, not a run from the start",
                "omit `integrator.method`: auto selects a method with steps, whose records it compares",
            ),
            _ => return,
        };
        let problem = Problem::new(self.place(TOLERANCE_OF), "the record has no tolerance here", reason);
        self.add(TOLERANCE_OF, problem.help(help));
    }

    /// Checks that a method that is named is suitable for the contact.
    fn check_method(&mut self, method: &str) {
        // A vibration at an angle to the sliding has its own methods and its own rule.
        if self.number("excitation.angle_deg").is_some_and(|angle| angle != 0.0) {
            return;
        }
        let has = |path: &str| self.given(path);
        let reason = match method {
            "linexp" | "frozen" | "closed" if has("contact.lugre") => "for LuGre friction use taylor, rk4-events or midpoint",
            "frozen" | "taylor" | "rk4" | "rk4-events" | "midpoint" if has("contact.coulomb") => {
                "Coulomb friction jumps at every reversal: linexp solves it exactly"
            }
            "closed" if has("rig.sdof") => "an oscillator has no closed form here",
            "frozen" if has("rig.kinematic") => "a prescribed motion has nothing to freeze: use linexp",
            other if has("contact.hertz") && has("rig.sdof") && !["auto", "rk4-events"].contains(&other) => {
                "a mass on a Hertzian contact can lose contact: use rk4-events, which locates each loss"
            }
            other if has("contact.hertz") && !has("rig.sdof") && !["auto", "closed"].contains(&other) => {
                "a Hertzian contact has only a closed form"
            }
            other if has("contact.compliant") && !has("rig.sdof") && !["auto", "closed"].contains(&other) => {
                "a compliant contact under vibration across it is solved piecewise, without steps"
            }
            _ => return,
        };
        let problem = Problem::new(self.place(METHOD), format!("{method} does not apply here"), reason);
        self.add(
            METHOD,
            problem.help("omit `integrator.method`: auto selects the cheapest method that meets the tolerance, and reports why"),
        );
    }
}
