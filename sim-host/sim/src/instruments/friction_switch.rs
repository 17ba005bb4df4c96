//! The friction switch: set point, estimate and truth of the friction ratio.

mod figure;
mod metrics;

pub use metrics::Step;

use super::{Instrument, View};
use crate::metrics::Metrics;
use report::Figure;

/// The instrument of scenes whose controller has a friction set point.
pub(super) struct FrictionSwitch;

impl Instrument for FrictionSwitch {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        run.switch(metrics);
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        figure::ratio(run).into_iter().collect()
    }
}
