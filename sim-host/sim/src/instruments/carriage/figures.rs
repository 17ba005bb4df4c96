//! Figures of a carriage over time: position and speed, pull and friction.

use super::stretch::pull;
use crate::instruments::View;
use crate::instruments::curves::{axis, curve, shaded};
use crate::record::Row;
use report::{Figure, Panel, Style};

/// Returns all figures; none without a carriage.
pub(super) fn all(run: &View) -> Vec<Figure> {
    if run.scene.carriage().is_none() {
        return Vec::new();
    }
    vec![forces(run), motion(run)]
}

fn forces(run: &View) -> Figure {
    let rows = run.rows;
    let mut series = vec![
        curve(rows, "true friction, mean over a block", "friction_true_n", Style::Line, |row| row.truth.friction_mean_n),
        curve(rows, "pull", "pull_n", Style::Dashed, |row| pull(row).pull_n),
    ];
    if run.scene.sensors.force_hz.is_some() {
        series.push(curve(rows, "friction by the force channel", "force_n", Style::Line, |row| row.force_n.unwrap_or(f64::NAN)));
    }
    Figure {
        id: "carriage-force".into(),
        title: "Carriage: pull and friction".into(),
        caption: "Without vibration, the friction follows the pull up to the static friction. With vibration, it hardly opposes \
                  the carriage. Before the first ON window, self-test, scan and lock also vibrate the contact."
            .into(),
        x: axis("time [s]"),
        y: axis("force [N]"),
        series,
        shaded: shaded(run),
        interactive: true,
        ..Figure::default()
    }
}

fn motion(run: &View) -> Figure {
    let rows = run.rows;
    let pulled = run.scene.carriage().is_some_and(|(_, carriage)| carriage.pull_m_per_s != 0.0);
    let mm = |of: fn(&Row) -> f64| move |row: &Row| 1e3 * of(row);
    let mut series = vec![curve(rows, "carriage", "carriage_mm", Style::Line, mm(|row| row.truth.belt_position_m))];
    if pulled {
        series.push(curve(rows, "end of the spring", "spring_end_mm", Style::Dashed, mm(|row| pull(row).end_m)));
    }
    let speed = curve(rows, "speed of the carriage", "carriage_mm_per_s", Style::Line, mm(|row| row.truth.belt_speed_m_per_s));
    Figure {
        id: "carriage-motion".into(),
        title: "Carriage: position and speed".into(),
        caption: "A carriage with stick-slip moves in steps; one that slides under vibration follows the end of its spring."
            .into(),
        x: axis("time [s]"),
        y: axis("position [mm]"),
        series,
        shaded: shaded(run),
        panels: vec![Panel { y: axis("speed [mm/s]"), series: vec![speed], ..Panel::default() }],
        interactive: true,
        ..Figure::default()
    }
}
