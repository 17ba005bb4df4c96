//! The edges of bursts: rise, fall, overshoot and residual vibration.

mod figures;
mod metrics;
mod windows;

use super::{Instrument, View};
use crate::metrics::Metrics;
use crate::record::Window;
use report::Figure;
use scene::Driven;

/// The instrument of every driven scene.
pub(super) struct Edges;

impl Instrument for Edges {
    fn windows(&self, scene: &Driven) -> Vec<Window> {
        windows::of(scene)
    }

    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        metrics::add(run, metrics);
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        figures::of(run)
    }
}
