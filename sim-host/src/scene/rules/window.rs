//! The window over which a contact study averages.

use super::Rules;
use crate::scene::diagnostic::Problem;
use crate::scene::nearest::shown;

const WINDOW: &str = "integrator.window_periods";
/// Rounding, relative to the length of the run.
const ROUNDING: f64 = 1e-9;

impl Rules<'_> {
    pub(super) fn window(&mut self) {
        let window = self.numbers(WINDOW);
        let Some(&[from, to]) = window.as_deref() else { return };
        if to <= from {
            let message = format!("the window ends at period {}, but begins at {} only", shown(to), shown(from));
            let problem = Problem::new(self.place(WINDOW), message, format!("the second must be more than {}", shown(from)));
            return self.add(WINDOW, problem.help("the means are over periods of the excitation: from, to"));
        }
        let (Some(duration), Some(hz)) = (self.number("duration_s"), self.number("excitation.frequency_hz")) else { return };
        let periods = duration * hz;
        if to <= periods * (1.0 + ROUNDING) {
            return;
        }
        let message = format!("the window ends at period {}, but the run has {}", shown(to), shown(periods));
        let at = self.newer(WINDOW, "duration_s");
        let label = if at == WINDOW {
            format!("the second must be at most {}", shown(periods))
        } else {
            format!("must be at least {} s", shown(to / hz))
        };
        let problem = Problem::new(self.place(at), message, label);
        self.add(
            WINDOW,
            problem.help(format!("`duration_s` of {} holds {} periods of {} Hz", shown(duration), shown(periods), shown(hz))),
        );
    }
}
