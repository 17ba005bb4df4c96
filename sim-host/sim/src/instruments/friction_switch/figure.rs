//! Figure of the friction ratio over time: command, estimate and truth.

use firmware::seam::telemetry::FrictionEstimate;

use super::set_point::SetPoint;
use crate::instruments::View;
use crate::instruments::curves::{axis, curve};
use crate::record::Row;
use report::{Figure, Style};

/// Returns the figure of the friction ratio, if the friction is switched.
pub(super) fn ratio(run: &View) -> Option<Figure> {
    let friction = run.scene.controller.friction.as_ref()?;
    let rows = run.rows;
    let begins_s = rows.iter().find(|row| row.friction.is_some())?.time_s;
    let coulomb_n = run.silent_friction_n()?;
    let held = &rows[rows.partition_point(|row| row.time_s < begins_s)..];
    let set_point = SetPoint::new(friction, coulomb_n);
    let estimate =
        |of: fn(&FrictionEstimate) -> f32| move |row: &Row| row.friction.as_ref().map_or(1.0, |estimate| f64::from(of(estimate)));
    Some(Figure {
        id: "friction-ratio".into(),
        title: "Friction ratio: command, estimate, truth".into(),
        caption:
            "Friction relative to that without vibration, after the survey. The estimate is that of the law at the measured tip \
             velocity; the truth is that of the simulated contact. Each point is a mean over several blocks. A set point below \
             the floor cannot be reached: the controller plays the maximum amplitude and reports a limit."
                .into(),
        x: axis("time [s]"),
        y: axis("friction ratio"),
        series: vec![
            curve(held, "truth", "friction_ratio_true", Style::Line, |row| row.truth.friction_mean_n / coulomb_n),
            curve(held, "controller's estimate", "friction_ratio_estimate", Style::Line, estimate(|estimate| estimate.ratio)),
            curve(held, "command", "friction_ratio_wanted", Style::Dashed, |row| set_point.at(row)),
            curve(held, "floor, estimated", "friction_floor_estimate", Style::Dashed, estimate(|estimate| estimate.floor)),
        ],
        interactive: true,
        ..Figure::default()
    })
}
