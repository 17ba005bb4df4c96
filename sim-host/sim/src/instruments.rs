//! Instruments: measurements of a run and their presentation. Each phenomenon has one folder with
//! its metrics, tables and figures.
//!
//! [`DRIVEN`] lists the instruments of a driven run. Metrics, reports and figures iterate over this
//! list; an instrument that does not apply to a scene adds nothing. The presentation of contact
//! studies and of several runs is in [`study`](crate::study).

mod average;
pub mod belt;
mod belt_stop;
mod carriage;
mod circuit;
pub mod crash;
pub(crate) mod curves;
mod drive;
mod edges;
mod energy;
mod friction;
pub mod friction_switch;
mod guard;
mod heat;
pub mod lock;
mod motor;
mod processor;
pub mod sweep;
mod view;

pub use view::View;

use crate::metrics::Metrics;
use crate::overlay::{self, Overlaid};
use crate::record::{Record, Window};
use report::{Figure, TableBlock};
use scene::Driven;

/// Headline metric of a report: label, metric, unit.
pub type Line = (&'static str, &'static str, &'static str);

/// One phenomenon of a driven run.
pub trait Instrument: Sync {
    /// Returns the windows of a run of this scene that must be recorded sample by sample.
    fn windows(&self, _scene: &Driven) -> Vec<Window> {
        Vec::new()
    }

    /// Adds the metrics of a run.
    fn metrics(&self, _run: &View, _metrics: &mut Metrics) {}

    /// Returns the headline metrics of a report.
    fn headline(&self) -> &'static [Line] {
        &[]
    }

    /// Returns sentences that a reader needs before the numbers.
    fn remarks(&self, _run: &View) -> Vec<String> {
        Vec::new()
    }

    /// Returns the tables of a run and its metrics.
    fn tables(&self, _run: &View, _metrics: &Metrics) -> Vec<TableBlock> {
        Vec::new()
    }

    /// Returns the figures of a run, the most important first.
    fn figures(&self, _run: &View) -> Vec<Figure> {
        Vec::new()
    }
}

/// All instruments of a driven run, in the order of a report.
pub static DRIVEN: [&dyn Instrument; 17] = [
    &guard::Guard,
    &crash::Crash,
    &motor::Motor,
    &friction_switch::FrictionSwitch,
    &belt_stop::BeltStop,
    &belt::Belt,
    &carriage::Carriage,
    &friction::Friction,
    &average::Average,
    &edges::Edges,
    &lock::Lock,
    &circuit::Circuit,
    &sweep::Sweep,
    &drive::Drive,
    &heat::Heat,
    &energy::EnergyBudget,
    &processor::ProcessorLoad,
];

/// Returns the windows of all instruments for a run of this scene.
pub fn windows(scene: &Driven) -> Vec<Window> {
    DRIVEN.iter().flat_map(|instrument| instrument.windows(scene)).collect()
}

/// Returns the metrics of a driven run.
pub fn measure(scene: &Driven, record: &Record) -> Metrics {
    metrics(&View::new(scene, record))
}

/// Returns the windows that a run needs only for its metrics: those of its figures if they are
/// compared with a measurement.
pub fn windows_of_metrics(scene: &Driven) -> Vec<Window> {
    if scene.overlay.is_empty() { Vec::new() } else { windows(scene) }
}

/// Returns the metrics of a driven run from its view.
pub fn metrics(view: &View) -> Metrics {
    overlaid(view).0
}

/// Returns the metrics of a driven run, and its figures with measured curves if the scene has any.
pub fn overlaid(view: &View) -> (Metrics, Option<Overlaid>) {
    let mut metrics = Metrics::default();
    for instrument in DRIVEN {
        instrument.metrics(view, &mut metrics);
    }
    metrics.put("plant_states", view.record.plant_states as f64);
    let overlaid = (!view.scene.overlay.is_empty()).then(|| overlay::lay(figures(view), &view.scene.overlay, None));
    overlay::put(overlaid.iter().flat_map(|laid| &laid.residuals), &mut metrics);
    (metrics, overlaid)
}

/// Returns the figures of a driven run, the most important first.
pub fn figures(view: &View) -> Vec<Figure> {
    DRIVEN.iter().flat_map(|instrument| instrument.figures(view)).collect()
}

/// Returns the headline metrics of a driven run.
pub fn headline() -> impl Iterator<Item = Line> {
    DRIVEN.iter().flat_map(|instrument| instrument.headline()).copied()
}
