//! A belt that stops under drive: how soon the drive is OFF, and how much energy a stretch of belt takes.

mod figures;
mod metrics;

use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use report::Figure;

/// The instrument of scenes with a belt encoder.
pub(super) struct BeltStop;

impl Instrument for BeltStop {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        run.belt_stop(metrics);
    }

    fn headline(&self) -> &'static [Line] {
        &[
            ("belt stops to drive OFF", "belt_stop_to_mute_ms", "ms"),
            ("rings down in", "ring_down_ms", "ms"),
            ("largest energy into a millimetre of belt", "exposure_j_per_mm", "J"),
        ]
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        figures::of(run)
    }
}
