//! Rules of the friction switch: its requirements outside its own table.

use super::Rules;
use super::drive::VELOCITY;
use crate::diagnostic::Problem;

const TABLE: &str = "controller.friction";
const FORCE: &str = "controller.friction.target_force_n";
const CHANNEL: &str = "sensors.force_hz";
const PREFER: &str = "controller.friction.prefer";
const PERIOD: &str = "controller.burst.period_s";
const STEPS: [&str; 2] = ["controller.friction.step_s", "controller.friction.step_ratio"];

impl Rules<'_> {
    pub(super) fn friction_switch(&mut self) {
        if !self.given(TABLE) {
            return;
        }
        let bursts = self.text(PREFER) == Some("bursts");
        let needs = [
            (
                TABLE,
                VELOCITY,
                true,
                "the friction switch controls the tip velocity, up to that of the drive",
                "the maximum velocity that the switch may use",
            ),
            (FORCE, CHANNEL, self.given(FORCE), "a target force needs a force channel", "or give `target_ratio`"),
            (PREFER, PERIOD, bursts, "bursts need a period", "their `duty` is set by the switch; the given value is ignored"),
        ];
        for (key, needed, applies, message, help) in needs {
            if applies && self.lacks(needed) {
                let problem = Problem::new(self.place(key), message, format!("needs `{needed}`"));
                self.add(needed, problem.help(help));
            }
        }
        self.friction_steps();
    }

    /// Checks for equal numbers of times and ratios, and for rising times.
    fn friction_steps(&mut self) {
        let [Some(times), Some(ratios)] = STEPS.map(|path| self.numbers(path)) else { return };
        let rising = times.windows(2).all(|pair| pair[0] < pair[1]);
        if times.len() == ratios.len() && rising {
            return;
        }
        let at = if self.given(STEPS[0]) { STEPS[0] } else { STEPS[1] };
        let label = if rising { "must have one time per ratio" } else { "each must be later than the one before" };
        let problem = Problem::new(self.place(at), "the steps of the friction are inconsistent", label);
        self.add(at, problem.help("`step_s` has the times, `step_ratio` the ratios"));
    }
}
