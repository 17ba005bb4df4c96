//! Rules of a friction law as text: its expressions, and the methods that solve it.

use std::collections::BTreeMap;

use super::Rules;
use crate::diagnostic::Problem;
use crate::schema::join;
use crate::tree::Node;
use contact::custom::{self, Source};

const EXPRESSION: &str = "contact.expression";
const METHOD: &str = "integrator.method";
const STEPS: &str = "integrator.steps_per_period";
const TOLERANCE_OF: &str = "integrator.tolerance_of";
const ANGLE: &str = "excitation.angle_deg";
const FRICTION_AT_START: &str = "excitation.friction0_n";

impl Rules<'_> {
    /// Checks the texts of a law, and that only collocation is to solve it.
    pub(super) fn expression(&mut self) {
        if self.value(EXPRESSION).is_none() {
            return;
        }
        if let Err(error) = custom::Expression::new(&self.source()) {
            let path = join(EXPRESSION, &error.key);
            let problem = Problem::new(self.place(&path), format!("`{path}`: {}", error.message), "wrong in this law");
            self.add(&path, problem);
        }
        let refusals = [
            (self.text(TOLERANCE_OF) == Some("record"), TOLERANCE_OF, "with a law of your own, only the mean has a tolerance"),
            (
                self.number(FRICTION_AT_START).is_some_and(|force| force != 0.0),
                FRICTION_AT_START,
                "a law of your own begins with the states of [contact.expression.start]",
            ),
            (self.value(STEPS).is_some(), STEPS, "the intervals of a law of your own adapt to the solution"),
            (self.number(ANGLE).is_some_and(|angle| angle != 0.0), ANGLE, "a law of your own has one direction of slip"),
            (
                self.text(METHOD).is_some_and(|method| !["auto", "collocation"].contains(&method)),
                METHOD,
                "a law of your own is solved only by collocation",
            ),
        ];
        for (_, path, reason) in refusals.into_iter().filter(|(is_refused, ..)| *is_refused) {
            let value = self.text(path).map_or_else(|| format!("`{path}`"), str::to_owned);
            let problem = Problem::new(self.place(path), format!("{value} does not apply here"), reason);
            self.add(path, problem.help("omit it"));
        }
    }

    fn source(&self) -> Source {
        let at = |name: &str| self.root.at(&join(EXPRESSION, name));
        let entries = |name: &str| at(name).and_then(Node::table).into_iter().flatten();
        let texts = |name: &str| entries(name).filter_map(|(name, entry)| Some((name.clone(), entry.node.text()?.to_owned())));
        let numbers = |name: &str| -> BTreeMap<String, f64> {
            entries(name).filter_map(|(name, entry)| Some((name.clone(), entry.node.number()?))).collect()
        };
        let relays = entries("relay").map(|(name, entry)| {
            let text = |key: &str| entry.node.at(key).and_then(Node::text).unwrap_or_default().to_owned();
            (name.clone(), (text("on"), text("off")))
        });
        Source {
            mu: self.number(&join(EXPRESSION, "mu")).unwrap_or_default(),
            rates: texts("rate").collect(),
            force: self.text(&join(EXPRESSION, "force")).unwrap_or_default().to_owned(),
            start: numbers("start"),
            parameters: numbers("parameter"),
            relays: relays.collect(),
        }
    }
}
