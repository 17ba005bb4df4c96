//! A vibration at an angle to the sliding, `excitation.angle_deg`: what is made of it.

use super::Rules;
use crate::diagnostic::Problem;
use crate::nearest::shown;

const ANGLE: &str = "excitation.angle_deg";
const METHOD: &str = "integrator.method";
const STEPS: &str = "integrator.steps_per_period";
const TOLERANCE_OF: &str = "integrator.tolerance_of";
const WAVEFORM: &str = "excitation.waveform";
const PERIODIC: [&str; 5] = ["sine", "square", "sawtooth", "triangle", "still"];

impl Rules<'_> {
    pub(super) fn angle(&mut self) {
        if self.number(ANGLE).unwrap_or_default() == 0.0 {
            if self.text(METHOD) == Some("collocation") {
                let reason = "it is for a vibration at an angle to the sliding, `excitation.angle_deg`";
                let problem = Problem::new(self.place(METHOD), "collocation cannot do this", reason);
                self.add(METHOD, problem.help("leave `integrator.method` out: auto takes the cheapest that meets the tolerance"));
            }
            return;
        }
        self.of_a_given_vibration();
        self.by_what();
        self.by_coulomb();
    }

    fn of_a_given_vibration(&mut self) {
        const IN_THE_PLANE: &str = "in the plane of the contact vibrate [contact.coulomb], [contact.dahl] and [contact.lugre]";
        let others = [
            (
                "rig.sdof",
                "only `rig.kinematic`, whose vibration is given, takes an angle; leave `angle_deg` out with [rig.sdof]"
                    .to_owned(),
            ),
            ("contact.hertz", format!("a Hertzian contact vibrates across the surface; {IN_THE_PLANE}")),
            ("contact.compliant", format!("a compliant contact vibrates across the surface; {IN_THE_PLANE}")),
        ];
        let Some((other, help)) = others.into_iter().find(|(other, _)| self.given(other)) else { return };
        let angle = shown(self.number(ANGLE).unwrap_or_default());
        let message = format!("a vibration at an angle of {angle} degrees to the sliding");
        self.add(ANGLE, Problem::new(self.place(ANGLE), message, format!("not with [{other}]")).help(help));
    }

    fn by_what(&mut self) {
        let coulomb = self.given("contact.coulomb");
        let (known, reason) = if coulomb {
            (["auto", "closed"], "Coulomb friction of a vibration at an angle has its closed form only")
        } else {
            (["auto", "collocation"], "bristles under a vibration at an angle are for collocation")
        };
        if let Some(method) = self.text(METHOD).filter(|method| !known.contains(method)) {
            let problem = Problem::new(self.place(METHOD), format!("{method} cannot do this"), reason);
            self.add(METHOD, problem.help("leave `integrator.method` out: auto takes the one that there is"));
        }
        if self.value(STEPS).is_some() {
            let message = "a vibration at an angle to the sliding has no steps a period";
            let problem = Problem::new(self.key(STEPS), message, "leave it out");
            self.add(STEPS, problem.help("its panels follow the solution, and are halved until they agree to round-off"));
        }
        if self.text(TOLERANCE_OF) == Some("record") {
            let reason = "a vibration at an angle to the sliding has a tolerance of its mean only";
            let problem = Problem::new(self.place(TOLERANCE_OF), "there is no record to have a tolerance", reason);
            let help = "leave `integrator.tolerance_of` out: then `error_estimate` is of the mean friction ratio";
            self.add(TOLERANCE_OF, problem.help(help));
        }
    }

    /// The closed form is of a whole period under one load.
    fn by_coulomb(&mut self) {
        if !self.given("contact.coulomb") {
            return;
        }
        if let Some(waveform) = self.text(WAVEFORM).filter(|waveform| !PERIODIC.contains(waveform)) {
            let message = format!("Coulomb friction of a {waveform} vibration at an angle to the sliding");
            let problem = Problem::new(self.place(WAVEFORM), message, "must be periodic with [contact.coulomb]");
            self.add(WAVEFORM, problem.help("its closed form is of one period; [contact.dahl] follows any waveform"));
        }
        for path in self.tables("disturbance") {
            let message = "Coulomb friction of a vibration at an angle to the sliding is that of one load";
            let problem = Problem::new(self.place(&path), message, "not with [contact.coulomb]");
            self.add(&path, problem.help("its closed form is of one period; [contact.dahl] follows a load that changes"));
        }
    }
}
