//! A travelling-wave motor: waves, rotor and lanes, and their closed forms.

mod figures;
mod metrics;
mod table;
mod window;

use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use crate::record::Window;
use report::{Figure, TableBlock};
use scene::Driven;

/// Instrument of scenes with a stator.
pub(super) struct Motor;

impl Instrument for Motor {
    fn windows(&self, scene: &Driven) -> Vec<Window> {
        window::wave_window(scene).into_iter().collect()
    }

    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        run.motor(metrics);
    }

    fn headline(&self) -> &'static [Line] {
        &[
            ("rotor speed", "rotor_speed_rad_per_s", "rad/s"),
            ("backward wave", "backward_wave_percent", "%"),
            ("rotor over surface speed", "rotor_speed_ratio", ""),
            ("stop time", "stop_time_ms", "ms"),
        ]
    }

    fn tables(&self, run: &View, metrics: &Metrics) -> Vec<TableBlock> {
        table::closed_forms(&run.scene, metrics).into_iter().collect()
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        figures::all(run)
    }
}
