//! Values of a key at which a metric of a sweep crosses a target, between neighbouring points.

use std::str::FromStr;

use serde_json::{Map, Value, json};

use super::super::solve::with_unit;
use report::TableBlock;
use scene::shown;
use sim::numbers::number;
use sim::study::sweep::design::Design;
use sim::study::sweep::{Rows, Sweep};

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

/// Crossings of a target along one key of a sweep over every combination of its keys.
pub(super) struct Crossings<'a> {
    target: &'a Target,
    /// Name or path of the scene.
    scene: &'a str,
    keys: Vec<&'a str>,
    /// Index of the key with the most values, along which the points are neighbours.
    along: usize,
    /// Values of all keys at each crossing, in the order of the points.
    found: Vec<Vec<f64>>,
    /// Smallest and largest value of the metric.
    range: Option<(f64, f64)>,
}

impl<'a> Crossings<'a> {
    /// Searches the rows of a complete sweep; `None` if its points are not every combination of the
    /// keys, or the metric is not one of its columns.
    pub(super) fn new(target: &'a Target, sweep: &'a Sweep, metrics: &[String], rows: &Rows) -> Option<Self> {
        let Design::Product(axes) = &sweep.design else { return None };
        let column = &rows.metrics[metrics.iter().position(|metric| *metric == target.metric)?];
        let counts: Vec<usize> = axes.iter().map(|axis| axis.count() as usize).collect();
        let along = (0..axes.len()).rev().max_by_key(|&axis| counts[axis])?;
        // The last axis changes fastest.
        let stride: usize = counts[along + 1..].iter().product();
        // The averages of a run that ended in a fault do not count.
        let faulted = |row: usize| rows.fault_codes.get(row).is_some_and(|code| code.is_some_and(|code| code != 0));
        let off = |row: usize| Some(column[row].filter(|_| !faulted(row))? - target.value);
        let crossing = |row: usize| {
            let (next, is_last) = (row + stride, row / stride % counts[along] + 1 == counts[along]);
            let (here, there) = (off(row)?, if is_last { f64::NAN } else { off(next)? });
            // A point on the target counts once: as the beginning of its interval.
            let part = if here == 0.0 { 0.0 } else { here / (here - there) };
            let crosses = here == 0.0 || here * there < 0.0;
            crosses.then(|| {
                let key = |(index, column): (usize, &Vec<f64>)| match index == along && part > 0.0 {
                    true => axes[along].between(column[row], column[next], part),
                    false => column[row],
                };
                rows.keys.iter().enumerate().map(key).collect()
            })
        };
        let values = || column.iter().flatten().copied().filter(|value| value.is_finite());
        let range = values().reduce(f64::min).zip(values().reduce(f64::max));
        let found = (0..rows.points.len()).filter_map(crossing).collect();
        Some(Crossings {
            target,
            scene: &sweep.loaded.origin,
            keys: axes.iter().map(|axis| axis.key.as_str()).collect(),
            along,
            found,
            range,
        })
    }

    /// Returns the crossings as a table, or as one sentence if there is none.
    pub(super) fn text(&self, styled: bool) -> String {
        let Target { metric, value } = self.target;
        let key = self.keys[self.along];
        if self.found.is_empty() {
            let (low, high) = self.range.map_or_else(|| ("–".to_owned(), "–".to_owned()), |(a, b)| (number(a), number(b)));
            return format!(
                "{metric} does not cross {} between neighbouring points: it is from {low} to {high}\n",
                shown(*value)
            );
        }
        let header: Vec<String> = self.keys.iter().map(|key| with_unit(key)).collect();
        let row = |values: &Vec<f64>| values.iter().map(|&value| number(value)).collect();
        let others =
            self.keys.iter().filter(|other| **other != key).map(|other| format!(" --set {other}=VALUE")).collect::<String>();
        let more = self.found.len().saturating_sub(MAX_PRINTED);
        let caption = format!(
            "{}Interpolated between neighbouring points along {key}. To compute it: sim-host solve {}{others} --for {metric}={} --by \
             {key}=LEAST:MOST",
            if more > 0 { format!("{more} more are in the JSON. ") } else { String::new() },
            self.scene,
            shown(*value)
        );
        let rows = self.found.iter().take(MAX_PRINTED).map(row).collect();
        TableBlock::new("crossings", &format!("Where {metric} is {}", shown(*value)), caption, &header, rows).terminal(styled)
    }

    /// Returns the crossings as JSON.
    pub(super) fn json(&self) -> Value {
        let keys =
            |values: &Vec<f64>| self.keys.iter().zip(values).map(|(key, value)| ((*key).to_owned(), json!(value))).collect();
        let found: Vec<Map<String, Value>> = self.found.iter().map(keys).collect();
        json!({ "metric": self.target.metric, "value": self.target.value, "along": self.keys[self.along], "crossings": found })
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
        Crossings::new(&target, &sweep, &[metric], &rows).unwrap().found
    }

    #[test]
    fn crossings_are_along_the_key_with_the_most_values() {
        let linear = |values: &[f64]| Some(values[0] + values[1]);
        let (mu, ratio) = ("contact.dahl.mu=1:5:5", "excitation.velocity_ratio=0.25,0.5");
        assert_eq!(found(&[mu, ratio], 3.5, linear), [[3.25, 0.25], [3.0, 0.5]]);
        assert_eq!(found(&[ratio, mu], 3.5, linear), [[0.25, 3.25], [0.5, 3.0]]);
    }

    #[test]
    fn a_point_on_the_target_counts_once_and_gaps_have_no_crossing() {
        assert_eq!(found(&["contact.dahl.mu=1:5:5"], 3.0, |values| Some(values[0])), [[3.0]]);
        assert_eq!(found(&["contact.dahl.mu=1:5:5"], 5.0, |values| Some(values[0])), [[5.0]]);
        assert!(found(&["contact.dahl.mu=1:5:5"], 3.5, |values| (values[0] != 4.0).then_some(values[0])).is_empty());
        let root = found(&["contact.dahl.stiffness_n_per_m=1:100:3:log"], 1.5, |values| Some(values[0].log10()))[0][0];
        assert!((root - 10f64.powf(1.5)).abs() < 1e-9, "{root}");
    }
}
