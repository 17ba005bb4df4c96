//! The range of a figure.

use super::axis::Scale;
use crate::figure::{Figure, Style};

/// Returns scales that show all data of the figure.
pub(super) fn scales(figure: &Figure) -> (Scale, Scale) {
    if let Some(map) = &figure.map {
        return map.scales(figure.x.log, figure.y.log);
    }
    let dots = figure.series.iter().any(|s| s.style == Style::Points);
    let mut xs: Vec<f64> = figure.all_series().flat_map(|s| s.x.iter().copied()).collect();
    xs.extend(figure.markers.iter().map(|m| m.x));
    let room = if figure.is_plane() {
        0.08
    } else if dots {
        0.03
    } else {
        0.0
    };
    let x = Scale::fit(&figure.x, &xs, [room, room], false).with_ticks(10);

    let seen = |value: f64| x.position(value).is_some_and(|p| x.shows(p));
    let mut ys: Vec<f64> = figure.markers.iter().map(|m| m.y).collect();
    ys.extend(figure.hlines.iter().map(|(y, _)| y));
    for series in &figure.series {
        for column in series.columns() {
            ys.extend(series.x.iter().zip(column).filter(|(x, _)| seen(**x)).map(|(_, y)| y));
        }
    }
    let headroom = if figure.shaded.is_empty() { 0.06 } else { 0.12 };
    let y = Scale::fit(&figure.y, &ys, [0.06, headroom], !figure.is_plane()).with_ticks(8);
    (x, y)
}
