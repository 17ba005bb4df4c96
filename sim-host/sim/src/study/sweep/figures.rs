//! Figures of a sweep, by its number of keys.
//!
//! | points | figure |
//! |---|---|
//! | one key | a curve of the metric |
//! | every combination of two, one with few values | a family of curves |
//! | every combination of two | a map |
//! | any other | parallel coordinates; for a sample also the metric over each key |
//!
//! Each figure shows one metric. Metrics that are equal at all points have none.

mod lines;
mod map;
mod parallel;

use super::design::Shape;
use super::unit;
use report::{Axis, Figure};
use scene::schema::{last_name, tail, words_of};

/// Maximum number of metrics with figures.
const MAX_METRICS: usize = 8;
/// Maximum number of curves of a family.
const MAX_FAMILY: u64 = 7;
/// Maximum number of points of a figure of separate points.
const MAX_DOTS: usize = 2000;
/// Maximum number of keys over which the metric of a sample is drawn.
const MAX_KEYS: usize = 6;

/// Columns of a sweep for the figures of one metric.
struct Data<'a> {
    keys: &'a [String],
    /// Values of each key.
    values: &'a [Vec<f64>],
    metric: &'a str,
    /// `true` for each key with logarithmic spacing.
    logs: &'a [bool],
    /// Metric at each point; NaN if missing.
    results: Vec<f64>,
}

/// Returns the figures of a sweep of these keys and metrics. `column` returns the values of a key
/// or a metric, with NaN for missing ones. With `contours`, two keys give a map even if one has few
/// values.
///
/// # Errors
/// If a column cannot be read.
pub fn all<E>(
    shape: &Shape,
    keys: &[String],
    metrics: &[String],
    contours: &[f64],
    column: impl Fn(&str) -> Result<Vec<f64>, E>,
) -> Result<Vec<Figure>, E> {
    let values = keys.iter().map(|key| column(key)).collect::<Result<Vec<_>, E>>()?;
    let mut figures: Vec<Figure> = Vec::new();
    let mut drawn = 0;
    for metric in metrics {
        if drawn == MAX_METRICS {
            break;
        }
        let results = column(metric)?;
        if varies(&results) {
            drawn += 1;
            let data = Data { keys, values: &values, metric, logs: &shape.logs, results };
            figures.extend(figures_of(shape, !contours.is_empty(), &data));
        }
    }
    for figure in &mut figures {
        match &mut figure.map {
            Some(map) => map.contours = once(contours),
            None if contours.is_empty() => {}
            None => figure.caption += " Contour lines need a map: two keys, each as START:STOP:N.",
        }
    }
    Ok(figures)
}

/// Returns each level once, in the order of its first occurrence.
fn once(levels: &[f64]) -> Vec<f64> {
    let firsts = levels.iter().enumerate().filter(|(at, level)| !levels[..*at].contains(level));
    firsts.map(|(_, level)| *level).collect()
}

fn figures_of(shape: &Shape, lines: bool, data: &Data) -> Vec<Figure> {
    match (data.keys.len(), shape.counts.as_deref()) {
        (1, _) => vec![lines::curve(data)],
        (2, Some(&[rows, columns])) => {
            let few = rows.min(columns) <= if lines { 1 } else { MAX_FAMILY };
            vec![if few || shape.uneven { lines::family(data, (rows, columns)) } else { map::draw(data, (rows, columns)) }]
        }
        _ => {
            let mut figures = vec![parallel::draw(data)];
            if shape.sample {
                figures.extend((0..data.keys.len().min(MAX_KEYS)).map(|key| lines::dots(data, key)));
            }
            figures
        }
    }
}

/// Returns `true` if there is more than one value, beyond round-off.
fn varies(values: &[f64]) -> bool {
    let (least, most) = extremes(values);
    most - least > 1e-12 * least.abs().max(most.abs())
}

/// Returns the smallest and the largest value, excluding NaN.
fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), &value| (least.min(value), most.max(value)))
}

impl Data<'_> {
    /// Returns words that distinguish a key from the others, and its unit.
    fn key(&self, place: usize) -> (String, String) {
        let key = &self.keys[place];
        let (tail, name) = (tail(key, self.keys), last_name(key));
        (if tail == name { words_of(name) } else { tail.to_owned() }, unit(key))
    }

    /// Returns the metric in words.
    fn words(&self) -> String {
        words(self.metric)
    }

    /// Returns the axis of a key.
    fn axis(&self, place: usize) -> Axis {
        let (words, unit) = self.key(place);
        Axis { log: self.logs[place], ..Axis::of(&words, &unit) }
    }
}

/// Returns a metric in words, without its unit.
pub(crate) fn words(metric: &str) -> String {
    axis(metric).label.split(" [").next().unwrap_or(metric).to_owned()
}

/// Returns the axis of a metric.
fn axis(name: &str) -> Axis {
    // A statistic of several runs has the name of the metric and a suffix.
    let unit = unit(name);
    let words = words_of(name);
    let words = words.strip_suffix(&format!(" {}", unit.to_lowercase())).unwrap_or(&words);
    let words = if unit == "%" { words.trim_end_matches(" percent") } else { words };
    Axis::of(words, &unit)
}

/// Returns a figure of a metric without curves.
fn figure(kind: &str, title: String, caption: &str, data: &Data) -> Figure {
    let missing = data.results.iter().filter(|value| value.is_nan()).count();
    let gone = if missing == 0 { String::new() } else { format!(" {missing} points have no value.") };
    Figure { id: format!("{kind}-{}", data.metric), title, caption: format!("{caption}{gone}"), ..Figure::default() }
}
