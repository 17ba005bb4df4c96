//! Preparation of a figure's values for drawing: magnitudes, values between samples, and units with
//! a prefix. The CSV has the original values.

use std::borrow::Cow;

use super::extent::scales;
use super::interpolate::between;
use crate::figure::{Axis, Figure, Series, Style};

/// Number of points of a drawn curve up to which samples are interpolated.
const MAX_POINTS: usize = 6000;
/// Largest number of parts of the step between two samples.
const MAX_PARTS: usize = 8;

/// Returns the figure as it is drawn.
pub(super) fn prepared(figure: &Figure) -> Cow<'_, Figure> {
    let magnitude = figure.y.magnitude || figure.panels.iter().any(|panel| panel.y.magnitude);
    let mut drawn = Cow::Borrowed(figure);
    if magnitude {
        let drawn = drawn.to_mut();
        let Figure { y, series, panels, .. } = &mut *drawn;
        let own = std::iter::once((&*y, series));
        for (axis, series) in own.chain(panels.iter_mut().map(|panel| (&panel.y, &mut panel.series))) {
            if axis.magnitude {
                series.iter_mut().for_each(|series| ys(series, f64::abs));
            }
        }
    }
    if figure.band_limited {
        let drawn = drawn.to_mut();
        drawn.series.iter_mut().chain(drawn.panels.iter_mut().flat_map(|panel| &mut panel.series)).for_each(smooth);
    }
    with_prefixes(drawn)
}

/// Adds values between the samples of a line.
fn smooth(series: &mut Series) {
    let parts = (MAX_POINTS / series.x.len().max(1)).min(MAX_PARTS);
    if parts > 1 && series.style == Style::Line {
        (series.x, series.y) = (between(&series.x, parts), between(&series.y, parts));
    }
}

/// Changes all values on the vertical axis.
fn ys(series: &mut Series, change: impl Fn(f64) -> f64) {
    let each = |values: &mut Vec<f64>| values.iter_mut().for_each(|value| *value = change(*value));
    each(&mut series.y);
    if let Style::Band { lower, upper } = &mut series.style {
        each(lower);
        each(upper);
    }
}

/// Units that get a prefix.
const UNITS: [&str; 11] = ["s", "m", "m/s", "N", "V", "A", "W", "J", "Hz", "S", "F"];
/// Prefixes and their exponents.
const PREFIXES: [(&str, i32); 6] = [("n", -9), ("µ", -6), ("m", -3), ("k", 3), ("M", 6), ("G", 9)];
/// Magnitude of the largest value below which a smaller unit is used.
const SMALL_UNIT_BELOW: f64 = 0.05;
/// Magnitude of the largest value from which on a larger unit is used.
const LARGE_UNIT_FROM: f64 = 1e4;
/// Relative extent of large values below which the unit is not changed.
const MIN_EXTENT_REL: f64 = 1e-4;
/// Largest ratio of the ends of a logarithmic axis that gets a prefix.
const MAX_PREFIX_RATIO: f64 = 1e3;

/// Returns exponent and label of the best readable unit for values of magnitude up to `largest`,
/// `extent` apart.
fn prefix(axis: &Axis, largest: f64, extent: f64) -> Option<(i32, String)> {
    let (quantity, unit) = axis.label.strip_suffix(']')?.rsplit_once('[')?;
    // Over many decades powers of ten are more readable than any prefix.
    let narrow = !axis.log || largest < MAX_PREFIX_RATIO * (largest - extent);
    let plain = narrow && UNITS.contains(&unit) && largest.is_finite() && largest > 0.0;
    if !plain
        || (SMALL_UNIT_BELOW..LARGE_UNIT_FROM).contains(&largest)
        || (largest >= LARGE_UNIT_FROM && extent < MIN_EXTENT_REL * largest)
    {
        return None;
    }
    // Values up to a thousand: 0.03 A is 30 mA.
    let wanted = 3 * (largest.log10() / 3.0).floor() as i32;
    let &(sign, exponent) = PREFIXES.iter().min_by_key(|(_, exponent)| (exponent - wanted).abs())?;
    Some((exponent, format!("{quantity}[{sign}{unit}]")))
}

fn with_prefixes(mut drawn: Cow<Figure>) -> Cow<Figure> {
    let seen = |low: f64, high: f64| (low.abs().max(high.abs()), high - low);
    let of = |figure: &Figure| {
        let (x, y) = scales(figure);
        (x.ends(), y.ends())
    };
    let (x_ends, y_ends) = of(&drawn);
    let (largest_x, extent_x) = seen(x_ends.0, x_ends.1);
    let (largest_y, extent_y) = seen(y_ends.0, y_ends.1);
    let mut x = prefix(&drawn.x, largest_x, extent_x);
    let mut y = prefix(&drawn.y, largest_y, extent_y);
    if drawn.is_plane() {
        // The same unit for both axes.
        let largest = largest_x.max(largest_y);
        (x, y) = (prefix(&drawn.x, largest, largest), prefix(&drawn.y, largest, largest));
    }
    if let Some((exponent, label)) = x {
        scale_x(drawn.to_mut(), 10f64.powi(-exponent), label);
    }
    if let Some((exponent, label)) = y {
        scale_y(drawn.to_mut(), 10f64.powi(-exponent), label);
    }
    for place in 0..drawn.panels.len() {
        let own = panel(&drawn, place);
        let (_, (low, high)) = of(&own);
        let (largest, extent) = seen(low, high);
        if let Some((exponent, label)) = prefix(&own.y, largest, extent) {
            let factor = 10f64.powi(-exponent);
            let panel = &mut drawn.to_mut().panels[place];
            panel.y = scaled(&panel.y, factor, label);
            panel.series.iter_mut().for_each(|series| ys(series, |y| factor * y));
            panel.hlines.iter_mut().for_each(|(y, _)| *y *= factor);
        }
    }
    drawn
}

fn scaled(axis: &Axis, factor: f64, label: String) -> Axis {
    Axis { label, range: axis.range.map(|(low, high)| (factor * low, factor * high)), ..axis.clone() }
}

fn scale_x(figure: &mut Figure, factor: f64, label: String) {
    figure.x = scaled(&figure.x, factor, label);
    let series = figure.series.iter_mut().chain(figure.panels.iter_mut().flat_map(|panel| &mut panel.series));
    series.for_each(|series| series.x.iter_mut().for_each(|x| *x *= factor));
    figure.shaded.iter_mut().for_each(|span| (span.from, span.to) = (factor * span.from, factor * span.to));
    figure.markers.iter_mut().for_each(|marker| marker.x *= factor);
    if let Some(map) = &mut figure.map {
        map.x = (factor * map.x.0, factor * map.x.1);
    }
}

fn scale_y(figure: &mut Figure, factor: f64, label: String) {
    figure.y = scaled(&figure.y, factor, label);
    figure.series.iter_mut().for_each(|series| ys(series, |y| factor * y));
    figure.hlines.iter_mut().for_each(|(y, _)| *y *= factor);
    figure.markers.iter_mut().for_each(|marker| marker.y *= factor);
    if let Some(map) = &mut figure.map {
        map.y = (factor * map.y.0, factor * map.y.1);
    }
}

/// Returns a panel as a separate figure, with the whole figure's range of x.
pub(super) fn panel(figure: &Figure, place: usize) -> Figure {
    let panel = &figure.panels[place];
    Figure {
        id: format!("{}-{}", figure.id, place + 2),
        x: Axis { range: Some(scales(figure).0.ends()), ..figure.x.clone() },
        y: panel.y.clone(),
        series: panel.series.clone(),
        hlines: panel.hlines.clone(),
        shaded: figure.shaded.clone(),
        interactive: figure.interactive,
        ..Figure::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(label: &str, y: &[f64]) -> Figure {
        let x = (0..y.len()).map(|n| n as f64).collect();
        let series = vec![Series { x, y: y.to_vec(), ..Series::default() }];
        Figure {
            y: Axis { label: label.into(), ..Axis::default() },
            series,
            hlines: vec![(y[0], "first".into())],
            ..Figure::default()
        }
    }

    fn drawn(label: &str, y: &[f64]) -> (String, Vec<f64>, f64) {
        let figure = figure(label, y);
        let drawn = prepared(&figure);
        (drawn.y.label.clone(), drawn.series[0].y.clone(), drawn.hlines[0].0)
    }

    #[test]
    fn units_get_the_prefix_that_reads_best() {
        let (label, y, line) = drawn("current [A]", &[0.0, 0.03]);
        assert_eq!((label.as_str(), line), ("current [mA]", 0.0));
        assert!((y[1] - 30.0).abs() < 1e-12);
        assert_eq!(drawn("frequency [Hz]", &[38e3, 42e3]).0, "frequency [kHz]");
        assert_eq!(drawn("way [m]", &[1e-6, 3e-6]).0, "way [µm]");
    }

    #[test]
    fn units_that_read_well_stay() {
        for (label, y) in [
            ("force [N]", [0.0, 0.14]),
            ("frequency [Hz]", [39_999.2, 39_999.9]),
            ("ratio", [0.0, 1e-3]),
            ("reduction [%]", [0.0, 1e-3]),
            ("time [ms]", [0.0, 2e4]),
        ] {
            assert_eq!(drawn(label, &y), (label.to_owned(), y.to_vec(), y[0]));
        }
    }

    #[test]
    fn magnitudes_do_not_change_the_figure() {
        let mut figure = figure("error [Hz]", &[-2.0, 1.0]);
        figure.y = Axis { log: true, magnitude: true, ..figure.y };
        assert_eq!(prepared(&figure).series[0].y, [2.0, 1.0]);
        assert_eq!(figure.series[0].y, [-2.0, 1.0]);
    }
}
