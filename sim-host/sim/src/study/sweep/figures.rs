//! The figures of a sweep, by how many keys it has.
//!
//! | points | figure |
//! |---|---|
//! | one key | a curve of the metric |
//! | every combination of two, one of few values | a family of curves |
//! | every combination of two | a map |
//! | any other | parallel coordinates; of a sample also the metric over each key |
//!
//! Each is of one metric. Metrics that are the same at all points have none.

mod lines;
mod map;
mod parallel;

use super::design::Shape;
use super::unit;
use report::{Axis, Figure};
use scene::schema::{last_name, tail, words_of};

/// Most metrics that have figures.
const METRICS: usize = 8;
/// Most curves of a family.
const FAMILY: u64 = 7;
/// Most points of a figure of separate points.
const DOTS: usize = 2000;
/// Most keys over which the metric of a sample is drawn.
const KEYS: usize = 6;

/// Columns of a sweep that are figures of one metric.
struct Data<'a> {
    keys: &'a [String],
    /// For each key its values.
    values: &'a [Vec<f64>],
    metric: &'a str,
    /// For each key whether its values are spread by ratios.
    logs: &'a [bool],
    /// The metric at each point; not a number where it is missing.
    results: Vec<f64>,
}

/// The figures of a sweep of these keys and metrics; `column` has the values of a key or a metric, which are not a number where they are missing.
///
/// # Errors
/// If a column cannot be read.
pub fn of<E>(
    shape: &Shape,
    keys: &[String],
    metrics: &[String],
    column: impl Fn(&str) -> Result<Vec<f64>, E>,
) -> Result<Vec<Figure>, E> {
    let values = keys.iter().map(|key| column(key)).collect::<Result<Vec<_>, E>>()?;
    let mut figures = Vec::new();
    let mut drawn = 0;
    for metric in metrics {
        if drawn == METRICS {
            break;
        }
        let results = column(metric)?;
        if varies(&results) {
            drawn += 1;
            figures.extend(figures_of(shape, &Data { keys, values: &values, metric, logs: &shape.logs, results }));
        }
    }
    Ok(figures)
}

fn figures_of(shape: &Shape, data: &Data) -> Vec<Figure> {
    match (data.keys.len(), shape.counts.as_deref()) {
        (1, _) => vec![lines::curve(data)],
        (2, Some(&[rows, columns])) => {
            let few = rows.min(columns) <= FAMILY;
            vec![if few || shape.uneven { lines::family(data, (rows, columns)) } else { map::of(data, (rows, columns)) }]
        }
        _ => {
            let mut figures = vec![parallel::of(data)];
            if shape.sample {
                figures.extend((0..data.keys.len().min(KEYS)).map(|key| lines::dots(data, key)));
            }
            figures
        }
    }
}

/// Whether there is more than one value, beyond round-off.
fn varies(values: &[f64]) -> bool {
    let (least, most) = extremes(values);
    most - least > 1e-12 * least.abs().max(most.abs())
}

/// The smallest and the largest value, of those that are numbers.
fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), &value| (least.min(value), most.max(value)))
}

impl Data<'_> {
    /// Words for a key that tell it from the other keys, and its unit.
    fn key(&self, place: usize) -> (String, String) {
        let key = &self.keys[place];
        let (tail, name) = (tail(key, self.keys), last_name(key));
        (if tail == name { words_of(name) } else { tail.to_owned() }, unit(key))
    }

    /// The axis of a key.
    fn axis(&self, place: usize) -> Axis {
        let (words, unit) = self.key(place);
        Axis { log: self.logs[place], ..Axis::of(&words, &unit) }
    }
}

/// The axis of a metric.
fn axis(name: &str) -> Axis {
    // Of several runs a metric has the name of one, and what of them it is.
    let unit = unit(name);
    let words = words_of(name);
    let words = words.strip_suffix(&format!(" {}", unit.to_lowercase())).unwrap_or(&words);
    let words = if unit == "%" { words.trim_end_matches(" percent") } else { words };
    Axis::of(words, &unit)
}

/// A figure of a metric, yet empty.
fn figure(kind: &str, title: String, caption: &str, data: &Data) -> Figure {
    let missing = data.results.iter().filter(|value| value.is_nan()).count();
    let gone = if missing == 0 { String::new() } else { format!(" {missing} points have no value.") };
    Figure { id: format!("{kind}-{}", data.metric), title, caption: format!("{caption}{gone}"), ..Figure::default() }
}
