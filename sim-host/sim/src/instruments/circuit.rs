//! Equivalent circuit of the transducer: as identified by the controller, and as simulated.

mod figure;
mod metrics;
mod table;

use super::{Instrument, View};
use crate::metrics::Metrics;
use report::{Figure, TableBlock};

/// Instrument of every driven scene.
pub(super) struct Circuit;

impl Instrument for Circuit {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        metrics::add(run, metrics);
    }

    fn tables(&self, run: &View, metrics: &Metrics) -> Vec<TableBlock> {
        vec![table::three_ways(run, metrics)]
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        figure::Admittance::from_run(run).map_or_else(Vec::new, |of| vec![figure::locus(run, &of), figure::bode(&of)])
    }
}
