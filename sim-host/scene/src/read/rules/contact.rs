//! Rules of the contact: dependencies between the numbers of its models.

use super::Rules;
use super::kind::Kind;
use crate::diagnostic::Problem;
use crate::nearest::shown;
use crate::schema::join;

const MODELS: [&str; 6] = ["coulomb", "dahl", "lugre", "hertz", "compliant", "expression"];
const ALPHA: &str = "contact.dahl.alpha";

impl Rules<'_> {
    pub(super) fn contact(&mut self) {
        self.exponent();
        let (mu, fixed) = (self.number("contact.lugre.mu"), self.number("contact.lugre.static_mu"));
        if let (Some(mu), Some(fixed)) = (mu, fixed)
            && fixed < mu
        {
            let message = format!("static friction of {} is less than kinetic friction of {}", shown(fixed), shown(mu));
            let at = self.newer("contact.lugre.static_mu", "contact.lugre.mu");
            let label = if at.ends_with("static_mu") {
                format!("must be at least {}", shown(mu))
            } else {
                format!("must be at most {}", shown(fixed))
            };
            let problem = Problem::new(self.place(at), message, label);
            self.add("contact.lugre.static_mu", problem.help("without a Stribeck effect, the two are equal"));
        }
        if self.kind == Some(Kind::Excited)
            && let Some(model) = self.model()
        {
            self.friction(&model);
            self.normal(&model);
        }
    }

    /// Returns the path of the contact's model, if there is one.
    pub(super) fn model(&self) -> Option<String> {
        MODELS.iter().map(|model| join("contact", model)).find(|path| self.given(path))
    }

    fn exponent(&mut self) {
        let Some(alpha) = self.number(ALPHA).filter(|alpha| *alpha != 1.0) else { return };
        let message = format!("Dahl's model with an exponent of {} is not implemented", shown(alpha));
        let problem = Problem::new(self.place(ALPHA), message, "must be 1");
        self.add(ALPHA, problem.help("exponent 1 is used by the thesis, and is solved exactly in slip"));
    }

    fn friction(&mut self, model: &str) {
        let mu = join(model, "mu");
        if self.number(&mu) == Some(0.0) {
            let message = format!("`{mu}` is 0, but without friction there is no friction ratio");
            let problem = Problem::new(self.place(&mu), message, "must be more than 0");
            self.add(
                &mu,
                problem.help("the ratio of two zero forces is undefined; 1e-9 is practically frictionless, and has a ratio"),
            );
        }
    }

    fn normal(&mut self, model: &str) {
        let normal = join(model, "normal_n");
        if self.given("rig.kinematic") && self.lacks(&normal) {
            let message = format!("`normal_n` is missing in [{model}]");
            let problem = Problem::new(self.place(model), message, "needs `normal_n`, a number in N");
            self.add(&normal, problem.help("[rig.kinematic] has no mass whose weight could be the normal force"));
        }
    }
}
