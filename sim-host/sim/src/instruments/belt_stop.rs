//! A belt that stops under drive: time until the drive is OFF, and energy into a section of belt.

mod figures;
mod metrics;

use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use report::Figure;

/// Instrument of scenes with a belt encoder.
pub(super) struct BeltStop;

impl Instrument for BeltStop {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        run.belt_stop(metrics);
    }

    fn headline(&self) -> &'static [Line] {
        &[
            ("belt stop to drive OFF", "belt_stop_to_mute_ms", "ms"),
            ("ring-down", "ring_down_ms", "ms"),
            ("largest energy per millimetre of belt", "exposure_j_per_mm", "J"),
        ]
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        figures::all(run)
    }
}
