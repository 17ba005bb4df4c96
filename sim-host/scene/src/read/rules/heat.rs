//! A stack whose losses grow and that heats itself: its laws must hold in all that the scene allows, and it must begin with its polarisation.

use super::kind::BELT;
use super::{Rules, shown};
use crate::diagnostic::Problem;
use crate::plant::LAW_FACTORS as FACTORS;
use crate::schema::join;
use crate::wording::{bound, quantity};

const THERMAL: &str = "stack.thermal";
const CURIE: &str = "stack.thermal.curie_c";
const DEPOLING: &str = "stack.thermal.depoling_c";
const AMBIENT: &str = "stack.thermal.ambient_c";
const TEMPERATURE: &str = "stack.temperature_k";
const BY_AMPLITUDE: &str = "stack.bvd.amplitude_rm_per_a2";
const MOST_BY_AMPLITUDE: &str = "stack.bvd.amplitude_rm_most";
const BY_TEMPERATURE: [(&str, &str); 2] =
    [("stack.bvd.temperature_rm_per_k", "motional resistance"), ("stack.bvd.temperature_force_factor_per_k", "force factor")];
const CURRENT_LIMIT: &str = "controller.limits.current_a";
const CURRENT_RANGE: &str = "sensors.i_full_scale_a";
impl Rules<'_> {
    pub(super) fn heat(&mut self) {
        if !self.given("stack") {
            return;
        }
        self.damped_by_a_belt();
        self.loss_by_amplitude();
        self.by_temperature();
        if self.given(THERMAL) {
            self.polarisation();
        }
    }

    /// The damping of a belt is part of the motional resistance, and no law of the ceramic moves it.
    fn damped_by_a_belt(&mut self) {
        for key in [BY_AMPLITUDE, BY_TEMPERATURE[0].0] {
            if self.given(BELT) && self.number(key).is_some_and(|number| number != 0.0) {
                let message = format!("`{key}` has no place beside [{BELT}]");
                let problem = Problem::new(self.key(key), message, "would move the belt's damping, too");
                self.add(
                    key,
                    problem.help("the damping of a belt is part of the motional resistance that the law would multiply"),
                );
            }
        }
    }

    /// Rm at the largest current that the scene allows.
    fn loss_by_amplitude(&mut self) {
        let Some(per_a2) = self.number(BY_AMPLITUDE).or_else(|| self.lacks(BY_AMPLITUDE).then_some(0.0)) else { return };
        if let Some(most) = self.value(MOST_BY_AMPLITUDE) {
            if per_a2 <= 0.0 {
                let message = format!("`{MOST_BY_AMPLITUDE}` ends what does not rise");
                let problem = Problem::new(most.place.clone(), message, "needs an `amplitude_rm_per_a2` above zero");
                self.add(MOST_BY_AMPLITUDE, problem);
            }
            return;
        }
        let (Some(limit_a), Some(range_a)) = (self.number(CURRENT_LIMIT), self.number(CURRENT_RANGE)) else { return };
        let (largest_a, of) = if limit_a <= range_a { (limit_a, CURRENT_LIMIT) } else { (range_a, CURRENT_RANGE) };
        let factor = 1.0 + per_a2 * largest_a * largest_a;
        if (FACTORS.0..=FACTORS.1).contains(&factor) {
            return;
        }
        let square = largest_a * largest_a;
        let ends = [(FACTORS.0 - 1.0) / square, (FACTORS.1 - 1.0) / square];
        let [least, most] = [bound(ends[0], 1.0, |x| x >= ends[0]), bound(ends[1], -1.0, |x| x <= ends[1])];
        let what = if factor <= 0.0 { ": Q would be negative" } else { "" };
        let message = format!(
            "at {}, the largest current (`{of}`), the law multiplies the motional resistance by {}{what}",
            quantity(largest_a, of),
            shown(factor)
        );
        let label =
            format!("must be from {} to {} 1/A^2 for a factor from {} to {}", shown(least), shown(most), FACTORS.0, FACTORS.1);
        let help = match factor > FACTORS.1 {
            true => format!("or give `{MOST_BY_AMPLITUDE}`, at which the rise ends, or a smaller `{CURRENT_LIMIT}`"),
            false => format!("or give a smaller `{CURRENT_LIMIT}`"),
        };
        let problem = Problem::new(self.place(BY_AMPLITUDE), message, label);
        self.add(BY_AMPLITUDE, problem.help(help));
    }

    /// Rm and phi at the temperatures that the scene states: the first one, those of steps, and the hottest of a stack that heats itself.
    fn by_temperature(&mut self) {
        let mut temperatures: Vec<f64> = self.stated_temperatures().into_iter().map(|(_, kelvin)| kelvin).collect();
        if self.given(THERMAL) {
            temperatures.extend(self.hottest_c().zip(self.number(AMBIENT)).map(|(hottest, ambient)| hottest - ambient));
        }
        for (key, what) in BY_TEMPERATURE {
            let Some(per_k) = self.number(key) else { continue };
            let leaves = |kelvin: &&f64| !(FACTORS.0..=FACTORS.1).contains(&(1.0 + per_k * **kelvin));
            let Some(&kelvin) = temperatures.iter().find(leaves) else { continue };
            let factor = 1.0 + per_k * kelvin;
            let message = format!("{} K over ambient the law multiplies the {what} by {}", shown(kelvin), shown(factor));
            let end = (if factor < 1.0 { FACTORS.0 } else { FACTORS.1 } - 1.0) / kelvin;
            let (way, word) = if end < 0.0 { (1.0, "least") } else { (-1.0, "most") };
            let end = bound(end, way, |x| way * (x - end) >= 0.0);
            let label = format!("must be at {word} {} 1/K for a factor from {} to {}", shown(end), FACTORS.0, FACTORS.1);
            let problem = Problem::new(self.place(key), message, label);
            let help = "a stack that heats itself may come to the hottest that its ceramic can be used at";
            self.add(key, if self.given(THERMAL) { problem.help(help) } else { problem });
        }
    }

    /// The temperatures that a scene states, K over ambient, with the paths where it does.
    fn stated_temperatures(&self) -> Vec<(String, f64)> {
        let of_temperature = |path: &String| self.text(&join(path, "key")) == Some(TEMPERATURE);
        let steps = self.tables("disturbance").into_iter().filter(of_temperature).map(|path| join(&path, "to"));
        let stated = std::iter::once(TEMPERATURE.to_owned()).chain(steps);
        stated.filter_map(|path| self.number(&path).map(|kelvin| (path, kelvin))).collect()
    }

    /// Hottest that the ceramic can be used, degrees Celsius.
    fn hottest_c(&self) -> Option<f64> {
        if self.given(DEPOLING) { self.number(DEPOLING) } else { self.number(CURIE).map(|curie| 0.5 * curie) }
    }

    /// The ceramic can be used up to its Curie point at most, and no temperature that the scene states is beyond.
    fn polarisation(&mut self) {
        if let (Some(depoling), Some(curie)) = (self.number(DEPOLING), self.number(CURIE))
            && depoling > curie
        {
            let at = self.newer(DEPOLING, CURIE);
            let message =
                format!("a ceramic cannot be used up to {} °C with its Curie point at {} °C", shown(depoling), shown(curie));
            let label = if at == DEPOLING {
                format!("must be at most {}", shown(curie))
            } else {
                format!("must be at least {}", shown(depoling))
            };
            let problem = Problem::new(self.place(at), message, label);
            self.add(at, problem.help("about half of the Curie point is usual; without `depoling_c` it is that"));
            return;
        }
        let (Some(hottest), Some(curie), Some(ambient)) = (self.hottest_c(), self.number(CURIE), self.number(AMBIENT)) else {
            return;
        };
        for (path, kelvin) in self.stated_temperatures() {
            let celsius = ambient + kelvin;
            if celsius < hottest {
                continue;
            }
            let what = if celsius >= curie {
                format!("above the Curie point of {} °C: the stack has no polarisation", shown(curie))
            } else {
                format!("above {} °C: the stack slowly loses its polarisation", shown(hottest))
            };
            let message = format!("{} K over ambient are {} °C, {what}", shown(kelvin), shown(celsius));
            let label = format!("must be less than {} K", shown(hottest - ambient));
            // Without a temperature of its own, the ambient one is too hot.
            let (at, label) = match self.given(&path) {
                true => (path.as_str(), label),
                false => (self.newer(AMBIENT, CURIE), format!("leaves {} K", shown(hottest - ambient))),
            };
            let problem = Problem::new(self.place(at), message, label);
            self.add(
                at,
                problem.help(format!(
                    "what such a stack still does is shown by a [[fault]] of the kind `depoled`, without [{THERMAL}]"
                )),
            );
        }
    }
}
