//! Friction switch: set point, estimate and truth of the friction ratio.

mod detents;
mod figure;
mod metrics;
mod set_point;

pub use metrics::Step;

use self::detents::Detents;
use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use report::Figure;

/// Instrument of scenes whose controller has a friction set point.
pub(super) struct FrictionSwitch;

impl Instrument for FrictionSwitch {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        run.switch(metrics);
        if let Some(detents) = Detents::from_run(run) {
            detents.metrics(metrics);
        }
    }

    fn headline(&self) -> &'static [Line] {
        &[
            ("depth of the detents, relative to the set point", "detent_depth", ""),
            ("lag of the friction on the knob's position", "detent_lag_ms", "ms"),
        ]
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        let detents = Detents::from_run(run).map(|detents| detents.figure());
        detents.into_iter().chain(figure::ratio(run)).collect()
    }
}
