//! Rules of a stack with variable losses or self-heating: its laws must be valid in the whole range
//! of the scene, and it must begin with its polarisation.

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
const BALANCE: [&str; 2] = ["controller.thermometer.resistance_k_per_w", "controller.thermometer.heat_capacity_j_per_k"];

impl Rules<'_> {
    pub(super) fn heat(&mut self) {
        if self.given(BALANCE[0]) && !self.given(BALANCE[1]) {
            let message = format!("`{}` needs the heat capacity", BALANCE[0]);
            let problem = Problem::new(self.key(BALANCE[0]), message, "the energy balance needs both");
            self.add(BALANCE[0], problem.help(format!("give `{}`, J/K: mass times specific heat", BALANCE[1])));
        }
        if !self.given("stack") {
            return;
        }
        self.check_belt_damping();
        self.check_loss_by_amplitude();
        self.check_by_temperature();
        if self.given(THERMAL) {
            self.check_polarisation();
        }
    }

    /// Checks that no law changes the motional resistance if it contains the damping of a belt.
    fn check_belt_damping(&mut self) {
        for key in [BY_AMPLITUDE, BY_TEMPERATURE[0].0] {
            if self.given(BELT) && self.number(key).is_some_and(|number| number != 0.0) {
                let message = format!("`{key}` cannot be combined with [{BELT}]");
                let problem = Problem::new(self.key(key), message, "would also change the belt's damping");
                self.add(
                    key,
                    problem.help("the damping by a belt is part of the motional resistance, which the law would multiply"),
                );
            }
        }
    }

    /// Checks Rm at the largest current of the scene.
    fn check_loss_by_amplitude(&mut self) {
        let Some(per_a2) = self.number(BY_AMPLITUDE).or_else(|| self.lacks(BY_AMPLITUDE).then_some(0.0)) else { return };
        if let Some(most) = self.value(MOST_BY_AMPLITUDE) {
            if per_a2 <= 0.0 {
                let message = format!("`{MOST_BY_AMPLITUDE}` limits a rise, but the resistance does not rise");
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
            true => format!("or give `{MOST_BY_AMPLITUDE}`, which limits the rise, or a smaller `{CURRENT_LIMIT}`"),
            false => format!("or give a smaller `{CURRENT_LIMIT}`"),
        };
        let problem = Problem::new(self.place(BY_AMPLITUDE), message, label);
        self.add(BY_AMPLITUDE, problem.help(help));
    }

    /// Checks Rm and the force factor at the temperatures of the scene: the first one, those of
    /// steps, and the highest operating temperature of a stack that heats itself.
    fn check_by_temperature(&mut self) {
        let mut temperatures: Vec<f64> = self.stated_temperatures().into_iter().map(|(_, kelvin)| kelvin).collect();
        if self.given(THERMAL) {
            temperatures.extend(self.hottest_c().zip(self.number(AMBIENT)).map(|(hottest, ambient)| hottest - ambient));
        }
        for (key, what) in BY_TEMPERATURE {
            let Some(per_k) = self.number(key) else { continue };
            let leaves = |kelvin: &&f64| !(FACTORS.0..=FACTORS.1).contains(&(1.0 + per_k * **kelvin));
            let Some(&kelvin) = temperatures.iter().find(leaves) else { continue };
            let factor = 1.0 + per_k * kelvin;
            let message = format!("at {} K over ambient, the law multiplies the {what} by {}", shown(kelvin), shown(factor));
            let end = (if factor < 1.0 { FACTORS.0 } else { FACTORS.1 } - 1.0) / kelvin;
            let (way, word) = if end < 0.0 { (1.0, "least") } else { (-1.0, "most") };
            let end = bound(end, way, |x| way * (x - end) >= 0.0);
            let label = format!("must be at {word} {} 1/K for a factor from {} to {}", shown(end), FACTORS.0, FACTORS.1);
            let problem = Problem::new(self.place(key), message, label);
            let help = "a stack that heats itself may reach the highest operating temperature of its ceramic";
            self.add(key, if self.given(THERMAL) { problem.help(help) } else { problem });
        }
    }

    /// Returns the temperatures that the scene gives, K over ambient, with their paths.
    fn stated_temperatures(&self) -> Vec<(String, f64)> {
        let of_temperature = |path: &String| self.text(&join(path, "key")) == Some(TEMPERATURE);
        let steps = self.tables("disturbance").into_iter().filter(of_temperature).map(|path| join(&path, "to"));
        let stated = std::iter::once(TEMPERATURE.to_owned()).chain(steps);
        stated.filter_map(|path| self.number(&path).map(|kelvin| (path, kelvin))).collect()
    }

    /// Returns the highest operating temperature of the ceramic, degrees Celsius.
    fn hottest_c(&self) -> Option<f64> {
        if self.given(DEPOLING) { self.number(DEPOLING) } else { self.number(CURIE).map(|curie| 0.5 * curie) }
    }

    /// Checks that the highest operating temperature is at most the Curie point, and that all
    /// temperatures of the scene are below it.
    fn check_polarisation(&mut self) {
        if let (Some(depoling), Some(curie)) = (self.number(DEPOLING), self.number(CURIE))
            && depoling > curie
        {
            let at = self.newer(DEPOLING, CURIE);
            let message =
                format!("an operating temperature of {} °C is above the Curie point of {} °C", shown(depoling), shown(curie));
            let label = if at == DEPOLING {
                format!("must be at most {}", shown(curie))
            } else {
                format!("must be at least {}", shown(depoling))
            };
            let problem = Problem::new(self.place(at), message, label);
            self.add(at, problem.help("about half of the Curie point is usual; this is the default of `depoling_c`"));
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
            // If the scene gives no temperature, the ambient one is too high.
            let (at, label) = match self.given(&path) {
                true => (path.as_str(), label),
                false => (self.newer(AMBIENT, CURIE), format!("allows only {} K", shown(hottest - ambient))),
            };
            let problem = Problem::new(self.place(at), message, label);
            self.add(
                at,
                problem.help(format!(
                    "for the behaviour of such a stack, use a [[fault]] of the kind `depoled`, without [{THERMAL}]"
                )),
            );
        }
    }
}
