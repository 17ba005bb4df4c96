//! A crash: forces, excursions and accelerations of the switched belt and of the passive one.

mod figures;
mod metrics;
mod ring;
mod table;
mod view;

pub use view::view;

use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use plant::dring::crash::Playback;
use report::{Figure, TableBlock};

/// Instrument of scenes with a D-ring.
pub(super) struct Crash;

impl Instrument for Crash {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        if let Some(playback) = playback(run) {
            metrics::add(playback, metrics);
        }
    }

    fn headline(&self) -> &'static [Line] {
        &[
            ("reduction of the force at the shoulder", "shoulder_force_reduction_percent", "%"),
            ("peak force, switched", "peak_shoulder_force_n", "N"),
            ("peak force, passive", "passive_peak_shoulder_force_n", "N"),
            ("excursion, switched", "torso_excursion_m", "m"),
            ("excursion, passive", "passive_torso_excursion_m", "m"),
            ("chest acceleration", "chest_acceleration_g", "g"),
            ("time to LOW friction", "switch_time_ms", "ms"),
        ]
    }

    fn remarks(&self, run: &View) -> Vec<String> {
        playback(run).map_or_else(Vec::new, |playback| table::remarks(run, playback))
    }

    fn tables(&self, run: &View, _: &Metrics) -> Vec<TableBlock> {
        playback(run).map(table::belts).into_iter().collect()
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        playback(run).map_or_else(Vec::new, |playback| {
            figures::all(playback).into_iter().chain(playback.ring.as_ref().map(ring::figure)).collect()
        })
    }
}

/// Returns the playback of a crash that has begun.
fn playback<'a>(run: &View<'a>) -> Option<&'a Playback> {
    run.record.crash.as_ref().filter(|playback| !playback.frames.is_empty())
}
