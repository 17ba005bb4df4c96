//! A travelling-wave motor: its waves, its rotor and its lanes, beside the closed forms.

mod figures;
mod metrics;
mod table;

use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use report::{Figure, TableBlock};

/// The instrument of scenes with a stator.
pub(super) struct Motor;

impl Instrument for Motor {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        run.motor(metrics);
    }

    fn headline(&self) -> &'static [Line] {
        &[
            ("rotor speed", "rotor_speed_rad_per_s", "rad/s"),
            ("backward wave", "backward_wave_percent", "%"),
            ("rotor over surface speed", "rotor_speed_ratio", ""),
            ("stops in", "stop_time_ms", "ms"),
        ]
    }

    fn tables(&self, run: &View, metrics: &Metrics) -> Vec<TableBlock> {
        table::closed_forms(&run.scene, metrics).into_iter().collect()
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        figures::of(run)
    }
}
