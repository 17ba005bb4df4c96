//! Rules of tracking: requirements of the firmware's scan and lock-in.

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

    /// Checks the number of steps of the coarse scan, each of one nominal bandwidth.
    fn scan(&mut self) {
        const MAX_SCAN_STEPS: f64 = 400.0;
        // Without tracking there is no scan.
        let scans = self.text("controller.tracking.mode").is_some_and(|mode| mode != "off");
        let (Some(q), Some(span)) = (self.number(Q), self.number(SPAN)) else { return };
        let steps = 2.0 * span * q;
        if !scans || steps <= MAX_SCAN_STEPS {
            return;
        }
        let most = |number: f64| {
            let end = MAX_SCAN_STEPS / (2.0 * number);
            shown(bound(end, -1.0, |x| x <= end))
        };
        let message = format!(
            "the scan would need {} steps of one bandwidth, but at most {MAX_SCAN_STEPS} are possible",
            shown(steps.ceil())
        );
        let label = format!("must be at most {} with a span of {}", most(span), shown(span));
        let problem = Problem::new(self.place(Q), message, label);
        let (q_shown, narrow) = (shown(q), most(q));
        self.add(Q, problem.help(format!("a Q of {q_shown} can be scanned with a `{SPAN}` of at most {narrow}")));
    }

    /// Checks that a block holds at least half a period of the drive, so that amplitude and phase
    /// can be measured.
    fn lock_in(&mut self) {
        const MIN_BLOCK_PERIODS: f64 = 0.5;
        let numbers = (self.number(FREQUENCY), self.number(SPAN), self.number(BLOCK), self.number("sensors.sample_hz"));
        let (Some(frequency_hz), Some(span), Some(samples), Some(sample_hz)) = numbers else { return };
        let lowest_hz = frequency_hz * (1.0 - span);
        if lowest_hz * samples / sample_hz >= MIN_BLOCK_PERIODS {
            return;
        }
        let message = format!("a block of {samples} samples holds less than half a period of {} Hz", shown(lowest_hz));
        let (needed_hz, needed) =
            (MIN_BLOCK_PERIODS * sample_hz / samples / (1.0 - span), MIN_BLOCK_PERIODS * sample_hz / lowest_hz);
        let faster = format!("{} Hz", shown(bound(needed_hz, 1.0, |hz| hz >= needed_hz)));
        let longest = Schema::root().at(BLOCK).and_then(|schema| schema.range().1).unwrap_or(samples);
        let longer = Some(needed.ceil()).filter(|needed| *needed <= longest);
        let at = self.newer(FREQUENCY, BLOCK);
        let (label, help) = match (at == FREQUENCY, longer) {
            (true, Some(longer)) => (faster, format!("or set `{BLOCK}` to at least {longer}")),
            (true, None) => (faster, format!("the longest block, `{BLOCK}` = {longest}, is too short for this frequency")),
            (false, Some(longer)) => (longer.to_string(), format!("or set `{FREQUENCY}` to at least {faster}")),
            (false, None) => {
                (format!("one more than {longest}, the largest value"), format!("set `{FREQUENCY}` to at least {faster}"))
            }
        };
        let problem = Problem::new(self.place(at), message, format!("must be at least {label}"));
        self.add(at, problem.help(help));
    }
}
