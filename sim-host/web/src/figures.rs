//! Figures for the page's plots: curves thinned to the resolution of a screen, in the format of a
//! report's script.

use report::decimate::{MAX_POINTS, keep};
use report::{Axis, Figure, HeatMap, Series, Style};
use serde_json::{Value, json};

/// Colours of curves, those of Okabe and Ito as in reports.
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#222222"];

/// Converts a figure: heading, caption and its plots from top to bottom.
pub(crate) fn figure(figure: &Figure) -> Value {
    let plane = figure.equal_aspect && !figure.x.log && !figure.y.log;
    let sorted =
        figure.series.iter().chain(figure.panels.iter().flat_map(|panel| &panel.series)).all(|series| series.x.is_sorted());
    let mut first = figure.series.len();
    let below = figure.panels.iter().enumerate().map(|(place, panel)| {
        let from = if panel.repeats { 0 } else { first };
        first = if panel.repeats { first } else { first + panel.series.len() };
        plot(figure, &format!("{}-{}", figure.id, place + 2), (&panel.y, &panel.series, &panel.hlines), from, false)
    });
    let own = plot(figure, &figure.id, (&figure.y, &figure.series, &figure.hlines), 0, true);
    let plots: Vec<Value> = std::iter::once(own).chain(below).collect();
    json!({
        "id": figure.id,
        "title": figure.title,
        "caption": figure.caption,
        // If x is not ascending, the curve is a path instead of a function.
        "path": plane || !sorted,
        "equal": plane,
        "map": figure.map.as_ref().map(map),
        "x": axis(&figure.x),
        "y": axis(&figure.y),
        "plots": if figure.map.is_some() { Vec::new() } else { plots },
    })
}

fn plot(
    figure: &Figure,
    id: &str,
    (y, series, lines): (&Axis, &[Series], &[(f64, String)]),
    first: usize,
    marked: bool,
) -> Value {
    let shown = series
        .iter()
        .enumerate()
        .filter(|(_, series)| series.x.iter().zip(&series.y).any(|(x, y)| x.is_finite() && y.is_finite()));
    let curves: Vec<Value> = shown.map(|(place, series)| curve(figure, y, first + place, series)).collect();
    let markers = figure.markers.iter().filter(|_| marked).map(|marker| (marker.x, marker.y, &marker.label));
    json!({
        "id": id,
        "x": axis(&figure.x),
        "y": axis(y),
        "series": curves,
        "spans": figure.shaded.iter().map(|span| (span.from, span.to, &span.label)).collect::<Vec<_>>(),
        "markers": markers.collect::<Vec<_>>(),
        "lines": lines,
    })
}

fn axis(axis: &Axis) -> Value {
    json!({ "label": axis.label, "log": axis.log, "range": axis.range, "names": axis.names })
}

fn curve(figure: &Figure, y: &Axis, place: usize, series: &Series) -> Value {
    let sized: Vec<Vec<f64>> = match &series.style {
        Style::Band { lower, upper } => vec![&series.y, lower, upper],
        _ => vec![&series.y],
    }
    .into_iter()
    .map(|column| if y.magnitude { column.iter().map(|y| y.abs()).collect() } else { column.clone() })
    .collect();
    let columns: Vec<&[f64]> = std::iter::once(&series.x).chain(&sized).map(Vec::as_slice).collect();
    // A position that does not exist on the axis would make the script reject the whole curve.
    let placed = |x: f64| x.is_finite() && (x > 0.0 || !figure.x.log);
    let places: Vec<usize> = keep(&columns, MAX_POINTS).into_iter().filter(|&place| placed(series.x[place])).collect();
    let value =
        |y_axis: &Axis, value: f64| Some(value).filter(|value| value.is_finite() && (*value > 0.0 || !y_axis.log)).map(rounded);
    let values: Vec<Vec<Option<f64>>> =
        sized.iter().map(|column| places.iter().map(|&place| value(y, column[place])).collect()).collect();
    json!({
        "name": series.name,
        "style": match series.style {
            Style::Line => "line",
            Style::Dashed => "dashed",
            Style::Points => "points",
            Style::Band { .. } => "band",
        },
        "color": COLOURS[place % COLOURS.len()],
        "x": places.iter().map(|&place| rounded(series.x[place])).collect::<Vec<_>>(),
        "columns": values,
    })
}

fn map(map: &HeatMap) -> Value {
    let columns: Vec<Vec<Option<f64>>> = map
        .columns
        .iter()
        .map(|column| column.iter().map(|&value| Some(rounded(value)).filter(|value| value.is_finite())).collect())
        .collect();
    json!({ "x": map.x, "y": map.y, "range": map.range, "label": map.label, "columns": columns })
}

/// Rounds to nine significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}
