//! The rule for the averaging window of a contact study.

use super::Rules;
use crate::diagnostic::Problem;
use crate::nearest::shown;
use crate::wording::bound;

const WINDOW: &str = "integrator.window_periods";
const DURATION: &str = "duration_s";
const FREQUENCY: &str = "excitation.frequency_hz";
/// Round-off, relative to the length of the run.
const ROUND_OFF_REL: f64 = 1e-9;

impl Rules<'_> {
    pub(super) fn window(&mut self) {
        let window = self.numbers(WINDOW);
        let Some(&[from, to]) = window.as_deref() else { return };
        if to <= from {
            let message = format!("the window ends at period {}, but begins at {}", shown(to), shown(from));
            let problem = Problem::new(self.place(WINDOW), message, format!("the second must be more than {}", shown(from)));
            return self.add(WINDOW, problem.help("the two numbers are periods of the excitation: from, to"));
        }
        let (Some(duration), Some(hz)) = (self.number(DURATION), self.number(FREQUENCY)) else { return };
        let periods = duration * hz;
        if to <= periods * (1.0 + ROUND_OFF_REL) {
            return;
        }
        let message = format!("the window ends at period {}, but the run has {}", shown(to), shown(periods));
        let at = self.newer(self.newer(WINDOW, DURATION), FREQUENCY);
        let longer = format!("{} s", shown(bound(to / hz, 1.0, |seconds| seconds >= to / hz)));
        let label = match at {
            WINDOW => format!("the second must be at most {}", shown(periods)),
            DURATION => format!("must be at least {longer}"),
            _ => format!("the run then has only {} periods", shown(periods)),
        };
        let problem = Problem::new(self.place(at), message, label);
        self.add(WINDOW, problem.help(format!("give a `{DURATION}` of at least {longer}, or another `{WINDOW}`")));
    }
}
