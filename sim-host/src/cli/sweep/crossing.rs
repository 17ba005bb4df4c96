//! Values of a key at which a metric of a sweep crosses a target, between neighbouring points.

use std::str::FromStr;

use serde_json::{Map, Value, json};

use super::super::solve::with_unit;
use report::TableBlock;
use scene::{metrics, shown};
use sim::numbers::number;
use sim::study::sweep::design::Design;
use sim::study::sweep::{Rows, Sweep, SweepError};

/// Maximum number of points whose rows are in memory at the end.
const MAX_SEARCHED: u64 = 10_000;
/// Maximum number of crossings that are printed.
const MAX_PRINTED: usize = 20;

/// A metric and its wanted value.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::cli) struct Target {
    /// Name of the metric.
    pub(in crate::cli) metric: String,
    /// Wanted value.
    pub(in crate::cli) value: f64,
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').and_then(|(metric, value)| Some((metric.trim(), value.trim().parse().ok()?)));
        let (metric, value) = parts
            .filter(|(metric, value): &(&str, f64)| !metric.is_empty() && value.is_finite())
            .ok_or_else(|| format!("`{text}` is not a metric with a number: write, for example, `reduction_percent=70`"))?;
        Ok(Target { metric: metric.to_owned(), value })
    }
}

impl Target {
    /// Refuses what cannot be searched, before the sweep.
    pub(super) fn check(&self, points: u64) -> Result<(), SweepError> {
        let metric = metrics::known(&self.metric).map_err(SweepError::Metric)?;
        let why = match metric {
            "fault_code" => format!("`{metric}` is not a quantity with a target"),
            _ if points > MAX_SEARCHED => {
                format!("a target is searched in at most {MAX_SEARCHED} points: `sim-host solve` finds it with fewer runs")
            }
            _ => return Ok(()),
        };
        Err(SweepError::Metric(why))
    }
}

/// Crossings of a target along one key of a sweep over every combination of its keys.
pub(super) struct Crossings<'a> {
    target: &'a Target,
    sweep: &'a Sweep<'a>,
    /// Index of the key with the most values, along which the points are neighbours.
    along: usize,
    /// Values of all keys at each crossing, and the last value of the key along which the metric
    /// keeps the target.
    found: Vec<(Vec<f64>, f64)>,
    /// Smallest and largest value of the metric.
    range: (f64, f64),
}

impl<'a> Crossings<'a> {
    /// Searches the rows of a complete sweep; `None` if its points are not every combination of the
    /// keys, or none has the metric.
    pub(super) fn new(target: &'a Target, sweep: &'a Sweep, columns: &[String], rows: &Rows) -> Option<Self> {
        let Design::Product(axes) = &sweep.design else { return None };
        let name = metrics::known(&target.metric).ok()?;
        let column = &rows.metrics[columns.iter().position(|column| column == name)?];
        let counts: Vec<usize> = axes.iter().map(|axis| axis.count() as usize).collect();
        let along = (0..axes.len()).rev().max_by_key(|&axis| counts[axis])?;
        // The last axis changes fastest.
        let stride: usize = counts[along + 1..].iter().product();
        // The averages of a run that ended in a fault do not count.
        let faulted = |row: usize| rows.fault_codes.get(row).is_some_and(|code| code.is_some_and(|code| code != 0));
        let off = |row: usize| column[row].filter(|value| value.is_finite() && !faulted(row)).map(|value| value - target.value);
        let values = || (0..rows.points.len()).filter_map(off);
        let range = values().reduce(f64::min).zip(values().reduce(f64::max))?;
        let key = &rows.keys[along];
        let mut found = Vec::new();
        for first in (0..rows.points.len()).filter(|row| (row / stride).is_multiple_of(counts[along])) {
            let mut line: Vec<usize> = (0..counts[along]).map(|place| first + place * stride).collect();
            line.sort_by(|&a, &b| key[a].total_cmp(&key[b]));
            let others = |value: f64| -> Vec<f64> {
                let of = |(index, column): (usize, &Vec<f64>)| if index == along { value } else { column[first] };
                rows.keys.iter().enumerate().map(of).collect()
            };
            let begun = found.len();
            // A metric that keeps the target over several points crosses it once.
            for on in line.chunk_by(|&a, &b| off(a) == Some(0.0) && off(b) == Some(0.0)).filter(|on| off(on[0]) == Some(0.0)) {
                found.push((others(key[on[0]]), key[on[on.len() - 1]]));
            }
            for pair in line.windows(2) {
                if let (Some(here), Some(there)) = (off(pair[0]), off(pair[1]))
                    && here * there < 0.0
                {
                    let at = axes[along].between(key[pair[0]], key[pair[1]], here / (here - there));
                    found.push((others(at), at));
                }
            }
            found[begun..].sort_by(|(_, a), (_, b)| a.total_cmp(b));
        }
        Some(Crossings { target, sweep, along, found, range: (range.0 + target.value, range.1 + target.value) })
    }

    /// Returns the crossings as a table, or as one sentence if there is none.
    pub(super) fn text(&self, styled: bool) -> String {
        let (Target { metric, value }, keys) = (self.target, self.sweep.design.keys());
        let key = keys[self.along];
        let (low, high) = self.range;
        let target = shown(*value);
        match &self.found[..] {
            [] if low == high => return format!("{metric} is {} at all points\n", number(low)),
            [] => {
                let (low, high) = (number(low), number(high));
                return format!("{metric} does not cross {target} between neighbouring points: it is from {low} to {high}\n");
            }
            _ => {}
        }
        let header: Vec<String> = keys.iter().map(|key| with_unit(key)).collect();
        let row = |(values, to): &(Vec<f64>, f64)| {
            let cell = |(index, &value): (usize, &f64)| match index == self.along && *to > value {
                true => format!("{} to {}", number(value), number(*to)),
                false => number(value),
            };
            values.iter().enumerate().map(cell).collect()
        };
        let more = self.found.len().saturating_sub(MAX_PRINTED);
        let more = if more > 0 { format!("{more} more are in the JSON. ") } else { String::new() };
        let caption = format!(
            "{more}Interpolated between neighbouring points along {key}; `sim-host solve` with `--for {metric}={target}` and `--by {key}=…` \
             computes it."
        );
        let rows = self.found.iter().take(MAX_PRINTED).map(row).collect();
        TableBlock::new("crossings", &format!("Where {metric} is {target}"), caption, &header, rows).terminal(styled)
    }

    /// Returns the crossings as JSON.
    pub(super) fn json(&self) -> Value {
        let keys = self.sweep.design.keys();
        let of = |(values, to): &(Vec<f64>, f64)| {
            let mut found: Map<String, Value> =
                keys.iter().zip(values).map(|(key, value)| ((*key).to_owned(), json!(value))).collect();
            found.insert("to".to_owned(), json!(to));
            Value::Object(found)
        };
        let found: Vec<Value> = self.found.iter().map(of).collect();
        json!({ "metric": self.target.metric, "value": self.target.value, "along": keys[self.along], "crossings": found })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::load::load;

    fn rows(design: &Design, of: impl Fn(&[f64]) -> Option<f64>) -> Rows {
        let mut rows = Rows::new(design.keys().len(), 1);
        for point in 0..design.count() {
            let values = design.values(point);
            let metric = of(&values);
            rows.points.push(point as i64);
            rows.keys.iter_mut().zip(&values).for_each(|(column, value)| column.push(*value));
            rows.metrics[0].push(metric);
        }
        rows
    }

    fn found(over: &[&str], target: f64, of: impl Fn(&[f64]) -> Option<f64>) -> Vec<Vec<f64>> {
        let design = Design::product(over.iter().map(|over| over.parse().unwrap()).collect()).unwrap();
        let (loaded, metric) = (load("contact-kinematic", &[]).unwrap(), "friction_ratio".to_owned());
        let target = Target { metric: metric.clone(), value: target };
        let rows = rows(&design, of);
        let sweep = Sweep::new(&loaded, design, std::slice::from_ref(&metric)).unwrap();
        Crossings::new(&target, &sweep, &[metric], &rows).unwrap().found.into_iter().map(|(values, _)| values).collect()
    }

    #[test]
    fn crossings_are_along_the_key_with_the_most_values() {
        let linear = |values: &[f64]| Some(values[0] + values[1]);
        let (mu, ratio) = ("contact.dahl.mu=1:5:5", "excitation.velocity_ratio=0.25,0.5");
        assert_eq!(found(&[mu, ratio], 3.5, linear), [[3.25, 0.25], [3.0, 0.5]]);
        assert_eq!(found(&["contact.dahl.mu=5,1,3"], 2.5, |values| Some(values[0])), [[2.5]]);
        assert_eq!(found(&[ratio, mu], 3.5, linear), [[0.25, 3.25], [0.5, 3.0]]);
    }

    #[test]
    fn a_point_on_the_target_counts_once_and_gaps_have_no_crossing() {
        assert_eq!(found(&["contact.dahl.mu=1:5:5"], 3.0, |values| Some(values[0])), [[3.0]]);
        assert_eq!(found(&["contact.dahl.mu=1:5:5"], 5.0, |values| Some(values[0])), [[5.0]]);
        assert_eq!(found(&["contact.dahl.mu=1:5:5"], 3.0, |values| Some(values[0].max(3.0))), [[1.0]]);
        assert!(found(&["contact.dahl.mu=1:5:5"], 3.5, |values| (values[0] != 4.0).then_some(values[0])).is_empty());
        let root = found(&["contact.dahl.stiffness_n_per_m=1:100:3:log"], 1.5, |values| Some(values[0].log10()))[0][0];
        assert!((root - 10f64.powf(1.5)).abs() < 1e-9, "{root}");
    }
}
