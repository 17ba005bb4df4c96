//! Edges of bursts: rise, fall, overshoot and residual vibration.

mod figures;
mod metrics;
mod windows;

use super::{Instrument, View};
use crate::metrics::Metrics;
use crate::record::Window;
use report::Figure;
use scene::Driven;

/// Instrument of every driven scene.
pub(super) struct Edges;

impl Instrument for Edges {
    fn windows(&self, scene: &Driven) -> Vec<Window> {
        windows::around_edges(scene)
    }

    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        metrics::add(run, metrics);
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        figures::all(run)
    }
}
