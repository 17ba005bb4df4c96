//! Tracking: what the firmware's scan and lock-in need of the numbers they are given.

use super::drive::FREQUENCY;
use super::{Rules, shown};
use crate::diagnostic::Problem;
use crate::schema::Schema;
use crate::wording::bound;

const Q: &str = "controller.tracking.nominal_q";
const SPAN: &str = "controller.tracking.span";
const BLOCK: &str = "controller.block_samples";

impl Rules<'_> {
    pub(super) fn tracking(&mut self) {
        self.scan();
        self.lock_in();
    }

    /// The coarse scan takes a step of one nominal bandwidth, and so many at most.
    fn scan(&mut self) {
        const MOST_STEPS: f64 = 400.0;
        // Where nothing is tracked, nothing is scanned.
        let scans = self.text("controller.tracking.mode").is_some_and(|mode| mode != "off");
        let (Some(q), Some(span)) = (self.number(Q), self.number(SPAN)) else { return };
        let steps = 2.0 * span * q;
        if !scans || steps <= MOST_STEPS {
            return;
        }
        let most = |number: f64| {
            let end = MOST_STEPS / (2.0 * number);
            shown(bound(end, -1.0, |x| x <= end))
        };
        let message = format!("the scan would need {} steps of one bandwidth, and has {MOST_STEPS}", shown(steps.ceil()));
        let label = format!("must be at most {} with a span of {}", most(span), shown(span));
        let problem = Problem::new(self.place(Q), message, label);
        let (q_shown, narrow) = (shown(q), most(q));
        self.add(Q, problem.help(format!("a Q of {q_shown} can be scanned with a `{SPAN}` of {narrow} at most")));
    }

    /// Amplitude and phase of a block are those of a tone: it must hold half a period of it.
    fn lock_in(&mut self) {
        const LEAST_PERIODS: f64 = 0.5;
        let numbers = (self.number(FREQUENCY), self.number(SPAN), self.number(BLOCK), self.number("sensors.sample_hz"));
        let (Some(frequency_hz), Some(span), Some(samples), Some(sample_hz)) = numbers else { return };
        let lowest_hz = frequency_hz * (1.0 - span);
        if lowest_hz * samples / sample_hz >= LEAST_PERIODS {
            return;
        }
        let message = format!("a block of {samples} samples holds less than half a period of {} Hz", shown(lowest_hz));
        let (needed_hz, needed) = (LEAST_PERIODS * sample_hz / samples / (1.0 - span), LEAST_PERIODS * sample_hz / lowest_hz);
        let faster = format!("{} Hz", shown(bound(needed_hz, 1.0, |hz| hz >= needed_hz)));
        let longest = Schema::root().at(BLOCK).and_then(|schema| schema.range().1).unwrap_or(samples);
        let longer = Some(needed.ceil()).filter(|needed| *needed <= longest);
        let at = self.newer(FREQUENCY, BLOCK);
        let (label, help) = match (at == FREQUENCY, longer) {
            (true, Some(longer)) => (faster, format!("or give `{BLOCK}` {longer} at least")),
            (true, None) => (faster, format!("no block is long enough for it; `{BLOCK}` is {longest} at most")),
            (false, Some(longer)) => (longer.to_string(), format!("or give `{FREQUENCY}` {faster} at least")),
            (false, None) => (format!("more than {longest}, which none is"), format!("give `{FREQUENCY}` {faster} at least")),
        };
        let problem = Problem::new(self.place(at), message, format!("must be at least {label}"));
        self.add(at, problem.help(help));
    }
}
