//! Drive voltage, power and tip motion, as root mean square and peak. These hold for any waveform,
//! an amplitude only for a sine.

use super::curves::{axis, binned, curve, mean, shaded};
use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use crate::record::Row;
use report::{Figure, Style};

/// Instrument of every driven scene.
pub(super) struct Drive;

impl Instrument for Drive {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        let rows: Vec<&Row> = run.steady().collect();
        if rows.is_empty() {
            return;
        }
        let mean = |value: &dyn Fn(&Row) -> f64| rows.iter().map(|row| value(row)).sum::<f64>() / rows.len() as f64;
        let largest = |value: &dyn Fn(&Row) -> f64| rows.iter().map(|row| value(row)).fold(0.0, f64::max);
        metrics.put("drive_peak_v", largest(&|row| row.swing.peak_v));
        metrics.put("drive_rms_v", mean(&|row| row.swing.square_v2).sqrt());
        metrics.put("drive_power_w", mean(&|row| row.truth.power_w));
        if rows.iter().all(|row| row.truth.tip.is_some()) {
            let tip = |row: &Row| row.truth.tip.unwrap_or_default();
            metrics.put("tip_velocity_rms_m_per_s", mean(&|row| tip(row).square_m2_per_s2).sqrt());
            metrics.put("tip_velocity_peak_m_per_s", largest(&|row| tip(row).peak_m_per_s));
        }
    }

    fn headline(&self) -> &'static [Line] {
        &[("tip velocity", "tip_velocity_m_per_s", "m/s")]
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        tip_velocity(run).into_iter().collect()
    }
}

/// Returns the figure of the tip velocity: command, estimate and truth.
fn tip_velocity(run: &View) -> Option<Figure> {
    let rows = run.rows;
    let nominal = run.scene.controller.tracking.nominal_force_factor_n_per_v?;
    let mut series = Vec::new();
    if let Some(velocity) = run.scene.ordered_velocity_m_per_s() {
        series.push(curve(rows, "command", "tip_velocity_command_m_per_s", Style::Dashed, |row| velocity * row.envelope));
    }
    series.push(curve(rows, "controller's estimate", "tip_velocity_estimate_m_per_s", Style::Line, |row| {
        row.motional_current_a / nominal
    }));
    series.push(curve(rows, "truth", "tip_velocity_true_m_per_s", Style::Line, |row| row.truth.tip_velocity_m_per_s));
    let largest = binned(rows).map(|bin| mean(bin, |row| row.truth.tip_velocity_m_per_s)).fold(0.0, f64::max);
    (largest > 0.0).then(|| Figure {
        id: "tip-velocity".into(),
        title: "Tip velocity: command, estimate, truth".into(),
        caption: "Peak velocity of the tip. The estimate is the motional current over the controller's nominal force factor; \
                  the truth is that of the simulated stack."
            .into(),
        x: axis("time [s]"),
        y: axis("tip velocity [m/s]"),
        series,
        shaded: shaded(run),
        interactive: true,
        ..Figure::default()
    })
}
