//! Parallel coordinates: a vertical axis for each key and one for the metric, with a line for each
//! point.

use super::{Data, extremes, figure};
use report::{Axis, Figure, Series, Style};
use scene::schema::tail;

/// Maximum number of lines of a class.
const MAX_LINES: usize = 30;
/// Margin outside the first and the last axis, for their names, in distances between axes.
const MARGIN: f64 = 0.3;

/// Draws the points with the smallest, middle and largest values of the metric, a tenth of each.
pub(super) fn draw(data: &Data) -> Figure {
    let mut order: Vec<usize> = (0..data.results.len()).filter(|&point| !data.results[point].is_nan()).collect();
    order.sort_by(|&a, &b| data.results[a].total_cmp(&data.results[b]).then(a.cmp(&b)));
    let tenth = (order.len() / 10).max(1).min(order.len());
    let middle = (order.len() - tenth) / 2;
    let spread = |(values, &log): (&Vec<f64>, &bool)| match log {
        true => values.iter().map(|value| value.ln()).collect(),
        false => values.clone(),
    };
    let mut columns: Vec<Vec<f64>> = data.values.iter().zip(data.logs).map(spread).collect();
    columns.push(data.results.clone());
    let scales: Vec<(f64, f64)> = columns.iter().map(|column| extremes(column)).collect();
    let part = |axis: usize, point: usize| {
        let (least, most) = scales[axis];
        if most > least { (columns[axis][point] - least) / (most - least) } else { 0.5 }
    };
    let class = |name: &str, points: &[usize]| {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for &point in points.iter().step_by(points.len().div_ceil(MAX_LINES).max(1)) {
            x.extend((0..columns.len()).map(|axis| axis as f64));
            y.extend((0..columns.len()).map(|axis| part(axis, point)));
            // A gap separates the lines.
            x.push(columns.len() as f64 - 1.0);
            y.push(f64::NAN);
        }
        Series { name: format!("{name} {}", data.metric), csv_column: name.replace(' ', "_"), x, y, style: Style::Line }
    };
    let names = data.keys.iter().map(|key| tail(key, data.keys).to_owned()).chain([data.metric.to_owned()]).collect();
    Figure {
        x: Axis { names, range: Some((-MARGIN, columns.len() as f64 - 1.0 + MARGIN)), ..Axis::default() },
        y: Axis { label: "fraction of the range of each".into(), range: Some((0.0, 1.0)), ..Axis::default() },
        series: vec![
            class("smallest", &order[..tenth]),
            class("middle", &order[middle..middle + tenth]),
            class("largest", &order[order.len() - tenth..]),
        ],
        ..figure(
            "parallel",
            format!("Smallest and largest {}", data.metric),
            "Lines of the points in the smallest, middle and largest tenth of its values, at most 30 each. Each axis spans the \
             range of its values; it shows logarithms if their spacing is logarithmic.",
            data,
        )
    }
}
