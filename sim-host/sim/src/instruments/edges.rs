//! The edges of bursts: rise, fall, overshoot and residual vibration.

mod figures;
mod metrics;

use super::{Instrument, View};
use crate::metrics::Metrics;
use report::Figure;

/// The instrument of every driven scene.
pub(super) struct Edges;

impl Instrument for Edges {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        metrics::add(run, metrics);
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        figures::of(run)
    }
}
