//! Rules of a vibration at an angle to the sliding, `excitation.angle_deg`.

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
            if self.text(METHOD) == Some("collocation") && !self.given("contact.expression") {
                let reason = "only for a vibration at an angle to the sliding, `excitation.angle_deg`";
                let problem = Problem::new(self.place(METHOD), "collocation does not apply here", reason);
                self.add(
                    METHOD,
                    problem.help("omit `integrator.method`: auto selects the cheapest method that meets the tolerance"),
                );
            }
            return;
        }
        self.check_vibration();
        self.check_angle_method();
        self.check_coulomb();
    }

    fn check_vibration(&mut self) {
        const IN_THE_PLANE: &str = "in the plane of the contact, use [contact.coulomb], [contact.dahl] or [contact.lugre]";
        let others = [
            (
                "rig.sdof",
                "only `rig.kinematic`, whose vibration is prescribed, supports an angle; omit `angle_deg` with [rig.sdof]"
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

    fn check_angle_method(&mut self) {
        let coulomb = self.given("contact.coulomb");
        let (known, reason) = if coulomb {
            (["auto", "closed"], "Coulomb friction under a vibration at an angle has only a closed form")
        } else {
            (["auto", "collocation"], "bristle friction under a vibration at an angle is solved only by collocation")
        };
        if let Some(method) = self.text(METHOD).filter(|method| !known.contains(method)) {
            let problem = Problem::new(self.place(METHOD), format!("{method} does not apply here"), reason);
            self.add(METHOD, problem.help("omit `integrator.method`: auto selects the only method"));
        }
        if self.value(STEPS).is_some() {
            let message = "a vibration at an angle to the sliding is not solved in steps";
            let problem = Problem::new(self.key(STEPS), message, "omit it");
            self.add(
                STEPS,
                problem.help("its intervals adapt to the solution, and are halved until the results agree to round-off"),
            );
        }
        if self.text(TOLERANCE_OF) == Some("record") {
            let reason = "for a vibration at an angle to the sliding, only the mean has a tolerance";
            let problem = Problem::new(self.place(TOLERANCE_OF), "the record has no tolerance here", reason);
            let help = "omit `integrator.tolerance_of`: `error_estimate` then refers to the mean friction ratio";
            self.add(TOLERANCE_OF, problem.help(help));
        }
    }

    /// Checks the conditions of the closed form, which covers one period: a periodic waveform and a
    /// constant load.
    fn check_coulomb(&mut self) {
        if !self.given("contact.coulomb") {
            return;
        }
        if let Some(waveform) = self.text(WAVEFORM).filter(|waveform| !PERIODIC.contains(waveform)) {
            let message = format!("Coulomb friction under a {waveform} vibration at an angle to the sliding");
            let problem = Problem::new(self.place(WAVEFORM), message, "must be periodic with [contact.coulomb]");
            self.add(WAVEFORM, problem.help("its closed form covers one period; [contact.dahl] supports any waveform"));
        }
        for path in self.tables("disturbance") {
            let message = "Coulomb friction under a vibration at an angle to the sliding needs a constant load";
            let problem = Problem::new(self.place(&path), message, "not with [contact.coulomb]");
            self.add(&path, problem.help("its closed form covers one period; [contact.dahl] supports a changing load"));
        }
    }
}
