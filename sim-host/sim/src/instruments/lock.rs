//! Lock: time to the resonance, accuracy after it, and correctness of the controller's lock
//! reports.

pub mod claims;
mod figures;
mod metrics;

use firmware::seam::mode::Mode;

use super::average::whole_periods;
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
        let period_s = run.scene.controller.burst.as_ref().and_then(|burst| burst.period_s);
        let bursts = match (period_s, whole_periods(run)) {
            (Some(_), Some(_)) => " No burst is long enough for one; `mean_…` are measured over whole periods.".to_owned(),
            (Some(period_s), None) => format!(" There is no whole burst period of {period_s} s either."),
            (None, _) => String::new(),
        };
        vec![format!("There is no steady block with the drive ON, so most metrics are missing: mode Run {running}.{bursts}")]
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        [figures::acquisition(run), figures::lock_acquisition(run), figures::over_time(run)].into_iter().flatten().collect()
    }
}
