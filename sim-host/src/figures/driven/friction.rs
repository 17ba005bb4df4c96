//! Friction and tip velocity over the whole run.

use super::{axis, binned, curve, mean, shaded};
use crate::metrics::driven::View;
use crate::report::{Figure, Series, Style};
use crate::study::driven::Run;

/// Friction over time: the true force with its extremes in each bin, and the slow load cell beside it.
pub(super) fn over_time(run: &Run, view: &View) -> Option<Figure> {
    // The pull of a belt has a figure of its own.
    run.scene.sliding()?;
    let rows = &run.record.rows;
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
            "The true friction at the tip swings within each vibration period (band); its mean is what slides. The load cell \
                  shows the mean and hides the edges. Before the first ON window, self-test, scan and lock drive the stack too."
                .into(),
        x: axis("time [s]"),
        y: axis("friction [N]"),
        series: vec![truth, cell],
        shaded: shaded(view),
        interactive: true,
        ..Figure::default()
    })
}

/// Tip velocity three ways.
pub(super) fn tip_velocity(run: &Run, view: &View) -> Option<Figure> {
    let rows = &run.record.rows;
    let told = run.scene.controller.tracking.nominal_force_factor_n_per_v?;
    let mut series = Vec::new();
    if let Some(velocity) = run.scene.ordered_velocity_m_per_s() {
        series.push(curve(rows, "command", "tip_velocity_command_m_per_s", Style::Dashed, |row| velocity * row.envelope));
    }
    series.push(curve(rows, "controller's estimate", "tip_velocity_estimate_m_per_s", Style::Line, |row| {
        row.motional_current_a / told
    }));
    series.push(curve(rows, "truth", "tip_velocity_true_m_per_s", Style::Line, |row| row.truth.tip_velocity_m_per_s));
    let largest = binned(rows).map(|bin| mean(bin, |row| row.truth.tip_velocity_m_per_s)).fold(0.0, f64::max);
    (largest > 0.0).then(|| Figure {
        id: "tip-velocity".into(),
        title: "Tip velocity: command, estimate, truth".into(),
        caption:
            "Peak velocity of the tip. The estimate is the motional current over the force factor that the controller is told; \
                  the truth is the simulated stack's."
                .into(),
        x: axis("time [s]"),
        y: axis("tip velocity [m/s]"),
        series,
        shaded: shaded(view),
        interactive: true,
        ..Figure::default()
    })
}
