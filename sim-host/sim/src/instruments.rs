//! Instruments: what is measured of a run, and how that is shown. One phenomenon has one folder, with its metrics, its tables and its figures.
//!
//! [`DRIVEN`] lists the instruments of a driven run. Metrics, reports and figures walk this list; an instrument of which a scene has nothing adds
//! nothing. What is shown of a contact study and of many runs stands with them, in [`study`](crate::study).

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

/// A metric that comes first in a report: label, metric, unit.
pub type Line = (&'static str, &'static str, &'static str);

/// One phenomenon of a driven run.
pub trait Instrument: Sync {
    /// The stretches of a run of this scene that are to be recorded sample by sample.
    fn windows(&self, _scene: &Driven) -> Vec<Window> {
        Vec::new()
    }

    /// Adds the metrics of a run.
    fn metrics(&self, _run: &View, _metrics: &mut Metrics) {}

    /// The metrics that come first in a report.
    fn headline(&self) -> &'static [Line] {
        &[]
    }

    /// Sentences that a reader needs before the numbers.
    fn remarks(&self, _run: &View) -> Vec<String> {
        Vec::new()
    }

    /// The tables of a run and its metrics.
    fn tables(&self, _run: &View, _metrics: &Metrics) -> Vec<TableBlock> {
        Vec::new()
    }

    /// The figures of a run, the most telling first.
    fn figures(&self, _run: &View) -> Vec<Figure> {
        Vec::new()
    }
}

/// All instruments of a driven run, in the order of a report.
pub static DRIVEN: [&dyn Instrument; 16] = [
    &guard::Guard,
    &crash::Crash,
    &motor::Motor,
    &friction_switch::FrictionSwitch,
    &belt_stop::BeltStop,
    &belt::Belt,
    &carriage::Carriage,
    &friction::Friction,
    &edges::Edges,
    &lock::Lock,
    &circuit::Circuit,
    &sweep::Sweep,
    &drive::Drive,
    &heat::Heat,
    &energy::EnergyBudget,
    &processor::ProcessorLoad,
];

/// The windows of all instruments, for a run of this scene.
pub fn windows(scene: &Driven) -> Vec<Window> {
    DRIVEN.iter().flat_map(|instrument| instrument.windows(scene)).collect()
}

/// The metrics of a driven run.
pub fn measure(scene: &Driven, record: &Record) -> Metrics {
    metrics(&View::new(scene, record))
}

/// The windows that a run needs for its metrics alone: those of its figures where these are held against a measurement.
pub fn windows_of_metrics(scene: &Driven) -> Vec<Window> {
    if scene.overlay.is_empty() { Vec::new() } else { windows(scene) }
}

/// The metrics of a driven run that is looked at already.
pub fn metrics(view: &View) -> Metrics {
    overlaid(view).0
}

/// The metrics of a driven run, and its figures with the measured curves over them where the scene has such.
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

/// The figures of a driven run, the most telling first.
pub fn figures(view: &View) -> Vec<Figure> {
    DRIVEN.iter().flat_map(|instrument| instrument.figures(view)).collect()
}
