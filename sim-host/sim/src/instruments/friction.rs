//! Friction of a sliding contact, switched by the vibration of its tip: true force, and reading of
//! a slow load cell.

use super::curves::{axis, binned, curve, shaded};
use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use crate::record::Row;
use report::statistics::mean;
use report::{Figure, Series, Style};
use scene::Slider;

/// Settling time of the load cell's reading after an edge, s.
const CELL_SETTLE_S: f64 = 0.05;

/// Instrument of scenes with a sliding contact.
pub(super) struct Friction;

impl Instrument for Friction {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        // A slider at rest has a force, but no sliding friction.
        let sliding = |slider: &&Slider| slider.speed_m_per_s != 0.0;
        let Some(slider) = run.scene.sliding().map(|(_, slider)| slider).filter(sliding) else { return };
        let force = |row: &Row| row.truth.friction_mean_n;
        let cell = |row: &Row| row.truth.load_cell_n;
        // The force of a stopped belt is not sliding friction either.
        let stops_s = run.scene.belt_stops_s().unwrap_or(f64::INFINITY);
        let off = |settle_s: f64| run.settled(0.0, settle_s).filter(move |row| row.time_s < stops_s);
        let off_n = mean(off(run.settle_s).map(force));
        let on = run.held().map_or_else(|| mean(run.steady().map(force)), |held| mean(held.iter().map(force)));
        metrics.put("friction_off_n", off_n);
        metrics.put("friction_on_n", on);
        let ratio = off_n.zip(on).map(|(off, on)| on / off);
        metrics.put("friction_ratio", ratio);
        metrics.put("reduction_percent", ratio.map(|ratio| 100.0 * (1.0 - ratio)));
        let off_n = mean(off(CELL_SETTLE_S).map(cell));
        let on = run.held().map_or_else(|| mean(run.settled(1.0, CELL_SETTLE_S).map(cell)), |held| mean(held.iter().map(cell)));
        metrics.put("load_cell_off_n", off_n);
        metrics.put("load_cell_on_n", on);
        metrics.put("load_cell_reduction_percent", off_n.zip(on).map(|(off, on)| 100.0 * (1.0 - on / off)));
        let tip = mean(run.steady().map(|row| row.truth.tip_velocity_m_per_s));
        metrics.put("velocity_ratio", tip.map(|tip| slider.speed_m_per_s / tip));
    }

    fn headline(&self) -> &'static [Line] {
        &[
            ("friction reduction", "reduction_percent", "%"),
            ("friction, drive OFF", "friction_off_n", "N"),
            ("friction, drive ON", "friction_on_n", "N"),
        ]
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        over_time(run).into_iter().collect()
    }
}

/// Returns the figure of friction over time: the true force with its extremes in each bin, and the
/// slow load cell.
fn over_time(run: &View) -> Option<Figure> {
    // The pull of a belt has its own figure.
    run.scene.sliding()?;
    let rows = run.rows;
    let (lower, upper) = binned(rows)
        .map(|bin| {
            let min = bin.iter().map(|row| row.truth.friction_min_n).fold(f64::INFINITY, f64::min);
            let max = bin.iter().map(|row| row.truth.friction_max_n).fold(f64::NEG_INFINITY, f64::max);
            (min, max)
        })
        .unzip();
    let truth =
        curve(rows, "true friction: mean, and extremes within a vibration period", "friction_true_n", Style::Line, |row| {
            row.truth.friction_mean_n
        });
    let truth = Series { style: Style::Band { lower, upper }, ..truth };
    let cell_hz = run.scene.sensors.load_cell_hz;
    let cell = curve(rows, &format!("load cell ({cell_hz} Hz)"), "load_cell_n", Style::Dashed, |row| row.truth.load_cell_n);
    Some(Figure {
        id: "friction".into(),
        title: "Friction, switched by ultrasound".into(),
        caption:
            "The true friction at the tip oscillates within each vibration period (band); its mean acts on the slider. The load \
             cell shows the mean and hides the edges. Before the first ON window, self-test, scan and lock also drive the \
             stack."
                .into(),
        x: axis("time [s]"),
        y: axis("friction [N]"),
        series: vec![truth, cell],
        shaded: shaded(run),
        interactive: true,
        ..Figure::default()
    })
}
