//! Lock: time to the resonance, accuracy after it, and correctness of the controller's lock
//! reports.

pub mod claims;
mod figures;
mod metrics;

use firmware::seam::mode::Mode;

use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use report::Figure;

/// Instrument of every driven scene.
pub(super) struct Lock;

impl Instrument for Lock {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        metrics::add(run, metrics);
    }

    fn headline(&self) -> &'static [Line] {
        &[
            ("frequency bias", "frequency_bias_hz", "Hz"),
            ("acquisition time", "acquire_time_ms", "ms"),
            ("relock time to 20 Hz", "relock_time_20hz_ms", "ms"),
        ]
    }

    fn remarks(&self, run: &View) -> Vec<String> {
        if run.record.crash.is_some() || run.record.last.fault.is_some() || run.steady().next().is_some() {
            return Vec::new();
        }
        let running = run.plays_from(Mode::Run).map_or("was not reached".to_owned(), |s| format!("began at {s:.3} s"));
        let bursts = run.scene.controller.burst.as_ref().is_some_and(|burst| burst.period_s.is_some());
        let cause = if bursts { " No burst is long enough for one; means over whole bursts are measured." } else { "" };
        vec![format!("There is no steady block with the drive ON, so most metrics are missing: mode Run {running}.{cause}")]
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        [figures::acquisition(run), figures::lock_acquisition(run), figures::over_time(run)].into_iter().flatten().collect()
    }
}
