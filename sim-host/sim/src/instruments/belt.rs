//! A belt under a horn: its pull, the empirical law of the pull, and deviations of the law from the
//! thesis.

mod figures;
pub mod law;
mod metrics;
mod table;

use super::{Instrument, View};
use crate::metrics::Metrics;
use report::{Figure, TableBlock};

/// Instrument of scenes with a belt under a horn.
pub(super) struct Belt;

impl Instrument for Belt {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        run.belt(metrics);
    }

    fn tables(&self, run: &View, metrics: &Metrics) -> Vec<TableBlock> {
        table::tables(&run.scene, metrics)
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        figures::all(run)
    }
}
