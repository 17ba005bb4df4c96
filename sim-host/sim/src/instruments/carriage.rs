//! A carriage on a vibrating tip: breakaway, stick-slip, release and hold.

mod figures;
mod metrics;
mod stretch;
mod table;

use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use report::{Figure, TableBlock};

/// Instrument of scenes with a carriage.
pub(super) struct Carriage;

impl Instrument for Carriage {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        metrics::pulled(run, metrics);
        metrics::released(run, metrics);
    }

    fn headline(&self) -> &'static [Line] {
        &[
            ("breakaway force, drive OFF", "breakaway_off_n", "N"),
            ("breakaway force, drive ON", "breakaway_on_n", "N"),
            ("stick-slip, drive OFF", "stick_slip_hz", "Hz"),
            ("rms of the speed over its mean, drive ON", "speed_ripple_on", ""),
            ("release time", "release_time_ms", "ms"),
            ("release energy", "release_energy_j", "J"),
        ]
    }

    fn tables(&self, run: &View, _: &Metrics) -> Vec<TableBlock> {
        table::stretches(run).into_iter().collect()
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        figures::all(run)
    }
}
