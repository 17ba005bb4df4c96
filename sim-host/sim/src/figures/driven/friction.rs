//! Friction and tip velocity over the whole run.

use firmware::seam::telemetry::Belief;

use super::{axis, binned, curve, mean, shaded};
use crate::metrics::driven::View;
use crate::metrics::driven::switch::configured;
use crate::record::Row;
use crate::study::driven::Run;
use report::{Figure, Series, Style};

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

/// The friction ratio three ways, where it is switched.
pub(super) fn ratio(run: &Run, view: &View) -> Option<Figure> {
    let friction = run.scene.controller.friction.as_ref()?;
    let rows = &run.record.rows;
    let begins_s = rows.iter().find(|row| row.friction.is_some())?.time_s;
    let coulomb_n = view.silent_friction_n()?;
    let held = &rows[rows.partition_point(|row| row.time_s < begins_s)..];
    let first = configured(friction, coulomb_n).unwrap_or(1.0);
    let wanted = |row: &Row| {
        let step = friction.step_s.iter().zip(&friction.step_ratio).rfind(|(at_s, _)| **at_s <= row.time_s);
        step.map_or(first, |(_, ratio)| *ratio)
    };
    let belief = |of: fn(&Belief) -> f32| move |row: &Row| row.friction.as_ref().map_or(1.0, |belief| f64::from(of(belief)));
    Some(Figure {
        id: "friction-ratio".into(),
        title: "Friction ratio: command, estimate, truth".into(),
        caption: "Friction over that without vibration, after the survey. The estimate is the law's, at the tip velocity that the controller measures; the \
                  truth is the simulated contact's, each point a mean over some blocks. Below the floor nothing is to be had: the loudest drive is what is \
                  played, and the controller says so."
            .into(),
        x: axis("time [s]"),
        y: axis("friction ratio"),
        series: vec![
            curve(held, "truth", "friction_ratio_true", Style::Line, |row| row.truth.friction_mean_n / coulomb_n),
            curve(held, "controller's estimate", "friction_ratio_estimate", Style::Line, belief(|belief| belief.ratio)),
            curve(held, "command", "friction_ratio_wanted", Style::Dashed, wanted),
            curve(held, "floor, estimated", "friction_floor_estimate", Style::Dashed, belief(|belief| belief.floor)),
        ],
        interactive: true,
        ..Figure::default()
    })
}
