//! Plots of cost against error.

use super::study::Study;
use super::work::{Curve, Point};
use report::{Axis, Figure, Series, Style};

/// Lower end of the error axis; smaller errors are round-off.
const MIN_ERROR: f64 = 1e-14;

/// Draws three figures: friction, its mean, displacement.
pub fn figures(study: &Study) -> Vec<Figure> {
    vec![
        figure(study, "work-friction", "Cost of friction over time", "largest error of F(t) / Fc", |point| point.errors.force),
        figure(study, "work-mean", "Cost of the mean friction ratio", "error of the mean friction ratio", |point| {
            point.errors.mean
        }),
        figure(study, "work-displacement", "Cost of displacement over time", "largest error of x(t) / max |x|", |point| {
            point.errors.displacement
        }),
    ]
}

/// Returns the range of the cost axis, with a margin on both sides.
fn cost_range(study: &Study) -> Option<(f64, f64)> {
    let costs = || study.curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.ns));
    Some((0.7 * costs().reduce(f64::min)?, 1.4 * costs().reduce(f64::max)?))
}

fn figure(study: &Study, id: &str, title: &str, y: &str, error: fn(&Point) -> f64) -> Figure {
    Figure {
        id: id.into(),
        title: title.into(),
        caption: "Table 4.1, 384 N at 60 kHz, velocity ratio 0.5, from rest, periods 100 to 200. Lower and further left is \
                  better. Solid: methods for a Dahl contact. Dashed: Runge-Kutta, midpoint, and the motion without the \
                  effect of friction."
            .into(),
        x: Axis { label: "time for a drive period [ns]".into(), log: true, range: cost_range(study), ..Axis::default() },
        y: Axis { label: y.into(), log: true, range: Some((MIN_ERROR, 1.0)), ..Axis::default() },
        series: study.curves.iter().map(|curve| series(curve, error)).collect(),
        ..Figure::default()
    }
}

fn series(curve: &Curve, error: fn(&Point) -> f64) -> Series {
    let ours = curve.method.role == super::method::Role::Ours;
    Series {
        name: curve.method.name.into(),
        csv_column: curve.method.name.into(),
        x: curve.points.iter().map(|point| point.ns).collect(),
        y: curve.points.iter().map(|point| error(point).max(MIN_ERROR)).collect(),
        style: if ours { Style::Line } else { Style::Dashed },
    }
}
