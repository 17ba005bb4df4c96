//! Data for the page's script to draw a zoomable figure.
//!
//! Curves are thinned and rounded to the resolution of a screen; the CSV next to the page has all
//! data.

use serde::Serialize;
use serde_json::{Value, json};

use super::extent::scales;
use super::style::{css, series_color};
use crate::decimate;
use crate::digits::rounded;
use crate::figure::{Figure, HeatMap, Series, Style};

/// A figure, as the script reads it.
#[derive(Debug, Serialize)]
pub(super) struct PlotData<'a> {
    id: &'a str,
    x: AxisData<'a>,
    y: AxisData<'a>,
    series: Vec<Curve<'a>>,
    spans: Vec<(f64, f64, &'a str)>,
    markers: Vec<(f64, f64, &'a str)>,
    lines: Vec<(f64, &'a str)>,
}

#[derive(Debug, Serialize)]
struct AxisData<'a> {
    label: &'a str,
    log: bool,
    /// Interval shown before the reader zooms; by default the script chooses it.
    range: Option<(f64, f64)>,
}

#[derive(Debug, Serialize)]
struct Curve<'a> {
    name: &'a str,
    style: &'static str,
    color: String,
    x: Vec<f64>,
    /// y, then the edges of a band.
    columns: Vec<Vec<f64>>,
}

/// Returns `true` if the figure can be zoomed: x must be in ascending order.
pub(super) fn can_zoom(figure: &Figure) -> bool {
    figure.interactive && figure.map.is_none() && !figure.is_plane() && figure.all_series().all(|s| s.x.is_sorted())
}

/// Returns the figure's data for the script, as it is drawn; `first` is the number of curves in the
/// plots above it.
pub(super) fn plot_data(figure: &Figure, first: usize) -> PlotData<'_> {
    let curves = figure.series.iter().enumerate().filter(|(_, series)| series.shows_something());
    PlotData {
        id: &figure.id,
        x: AxisData { label: &figure.x.label, log: figure.x.log, range: Some(scales(figure).0.ends()) },
        y: AxisData { label: &figure.y.label, log: figure.y.log, range: figure.y.range },
        series: curves.map(|(index, series)| curve(figure, first + index, series)).collect(),
        spans: figure.shaded.iter().map(|s| (s.from, s.to, s.label.as_str())).collect(),
        markers: figure.markers.iter().map(|m| (m.x, m.y, m.label.as_str())).collect(),
        lines: figure.hlines.iter().map(|(y, label)| (*y, label.as_str())).collect(),
    }
}

fn curve<'a>(figure: &Figure, index: usize, series: &'a Series) -> Curve<'a> {
    let (from, to) = figure.x.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let start = series.x.partition_point(|&x| x < from).saturating_sub(1);
    let end = (series.x.partition_point(|&x| x <= to) + 1).min(series.x.len()).max(start);
    let shown: Vec<&[f64]> =
        std::iter::once(series.x.as_slice()).chain(series.columns()).map(|column| &column[start..end]).collect();
    let (xs, columns) = (shown[0], &shown[1..]);

    // A position that does not exist on the axis would make the script reject the whole curve.
    let placed = |x: f64| x.is_finite() && (x > 0.0 || !figure.x.log);
    let indices: Vec<usize> = decimate::keep(&shown, decimate::MAX_POINTS).into_iter().filter(|&i| placed(xs[i])).collect();
    let value = |y: f64| if y > 0.0 || !figure.y.log { rounded(y, 9) } else { f64::NAN };
    Curve {
        name: &series.name,
        style: match series.style {
            Style::Line => "line",
            Style::Dashed => "dashed",
            Style::Points => "points",
            Style::Band { .. } => "band",
        },
        color: css(series_color(index)),
        x: distinct(indices.iter().map(|&i| xs[i])),
        columns: columns.iter().map(|c| indices.iter().map(|&i| value(c[i])).collect()).collect(),
    }
}

/// Returns the values of a map's cells and of the keys at their centres, with names and units.
pub(super) fn map_data(figure: &Figure, map: &HeatMap) -> Value {
    let parts = [&figure.x.label, &figure.y.label, &map.label]
        .map(|label| label.strip_suffix(']').and_then(|label| label.rsplit_once(" [")).unwrap_or((label, "")));
    let most = 1e-4 * (map.range.1 - map.range.0);
    let column = |column: &Vec<f64>| column.iter().map(|&value| readable(value, most)).collect::<Vec<_>>();
    json!({
        "names": parts.map(|(name, _)| name), "units": parts.map(|(_, unit)| unit),
        "log": [figure.x.log, figure.y.log],
        "x": centres(map.x, figure.x.log, map.size().0), "y": centres(map.y, figure.y.log, map.size().1),
        "columns": map.columns.iter().map(column).collect::<Vec<_>>(),
    })
}

/// Returns the values at the centres of `count` cells along an axis, with the digits that
/// distinguish them.
fn centres((low, high): (f64, f64), log: bool, count: usize) -> Vec<f64> {
    let between = |part: f64| if log { low * (high / low).powf(part) } else { low + part * (high - low) };
    let value = |cell: f64| between(cell / count as f64);
    let centre = |cell: usize| (value(cell as f64 + 0.5), value(cell as f64 + 1.0));
    (0..count).map(centre).map(|(centre, edge)| readable(centre, 0.01 * (edge - centre))).collect()
}

/// Rounds to the fewest digits, but at least four, that change the value by at most `most`.
fn readable(value: f64, most: f64) -> f64 {
    (4..=9).map(|digits| rounded(value, digits)).find(|near| (near - value).abs() <= most).unwrap_or(value)
}

/// Makes equal positions distinct: the script merges samples at equal x, which would flatten a
/// step.
fn distinct(places: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut result: Vec<f64> = Vec::new();
    for x in places {
        let next = result.last().map_or(x, |last| x.max(last.next_up()));
        result.push(next);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Axis;

    fn figure(x: Vec<f64>, y: Vec<f64>) -> Figure {
        let series = vec![Series { x, y, ..Series::default() }];
        Figure { series, interactive: true, ..Figure::default() }
    }

    fn json(figure: &Figure) -> Value {
        serde_json::to_value(plot_data(figure, 0)).unwrap()
    }

    #[test]
    fn non_finite_values_become_null() {
        let figure = figure(vec![0.0, 1.0, 2.0], vec![f64::NAN, f64::INFINITY, 0.1 + 0.2]);
        assert_eq!(json(&figure)["series"][0]["columns"][0].to_string(), "[null,null,0.3]");
    }

    #[test]
    fn cells_of_a_map_are_read_with_their_keys() {
        let columns = vec![vec![0.123_456, f64::NAN], vec![2e-7, 1.0], vec![0.5, 0.5]];
        let map = HeatMap { x: (0.5, 3.5), y: (1.0, 1e4), columns, label: "power [W]".into(), ..HeatMap::default() };
        let y = Axis { log: true, ..Axis::of("stiffness", "N/m") };
        let data = map_data(&Figure { map: Some(map.clone()), y, ..Figure::default() }, &map);
        assert_eq!([&data["names"], &data["units"]], [&json!(["", "stiffness", "power"]), &json!(["", "N/m", "W"])]);
        assert_eq!([&data["x"], &data["y"]], [&json!([1.0, 2.0, 3.0]), &json!([10.0, 1000.0])]);
        assert_eq!(data["columns"], json!([[0.123456, null], [2e-7, 1.0], [0.5, 0.5]]));
        assert_eq!([0.01, 1.0].map(|most| readable(39_997.5, most)), [39_997.5, 39_998.0]);
    }

    #[test]
    fn a_locus_cannot_be_zoomed() {
        assert!(!can_zoom(&figure(vec![0.0, 1.0, 0.5], vec![0.0; 3])));
        assert!(!can_zoom(&figure(vec![0.0, f64::NAN], vec![0.0; 2])));
        assert!(can_zoom(&figure(vec![0.0, 0.0, 1.0], vec![0.0; 3])));
    }

    #[test]
    fn steps_stay_steps() {
        let data = json(&figure(vec![1.0, 1.0, 2.0], vec![0.0, 5.0, 5.0]));
        let x: Vec<f64> = serde_json::from_value(data["series"][0]["x"].clone()).unwrap();
        assert!(x[0] < x[1] && x[1] < 1.000_001);
    }

    #[test]
    fn only_the_visible_range_is_sent() {
        let x: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut figure = figure(x.clone(), x);
        figure.x.range = Some((500.0, 600.0));
        assert_eq!(json(&figure)["series"][0]["x"].as_array().unwrap().len(), 103);
    }
}
