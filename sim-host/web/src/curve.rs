//! A metric over a key: the points of a curve and the search for a target between two of them.

use serde::Deserialize;
use serde_json::{Value, json};
use sim::study::solve::{REACHED_REL, Search};
use sim::study::{self, Options};

use crate::request::Request;

/// Largest width of the interval of a root, relative to the root.
const ROOT_WIDTH_REL: f64 = 1e-6;

impl Request {
    /// Runs the scene. Returns the requested metric.
    ///
    /// # Errors
    /// The reason that the run has none.
    pub fn point(&self) -> Result<f64, String> {
        let loaded = self.load()?;
        let metrics = study::run(&loaded, Options::default()).map_err(|error| error.to_string())?.rest.metrics;
        match metrics.find("fault_code").filter(|code| *code != 0.0 && loaded.scene.runs == 1) {
            Some(code) => Err(format!("the run ends in fault {code}")),
            None => metrics.find(&self.metric).filter(|value| value.is_finite()).ok_or("the run has no such number".to_owned()),
        }
    }
}

/// A search for the value of a key at which a metric has a target.
#[derive(Clone, Debug, Deserialize)]
pub struct Target {
    /// Value of the metric.
    pub target: f64,
    /// Values of the key with the metric: two points with the target between them, then all points
    /// of the search so far.
    pub points: Vec<(f64, f64)>,
}

impl Target {
    /// Returns `next`, the next value of the key to run. At the end of the search it is null, and
    /// `root` is the value at which the metric has the target. `root` is null if the metric steps
    /// over the target, at `at`.
    pub fn next(&self) -> Value {
        let mut points = self.points.iter().map(|&(at, metric)| (at, metric - self.target));
        let Some((low, high)) = points.next().zip(points.next()) else { return Value::Null };
        let mut search = Search::new(low, high, ROOT_WIDTH_REL);
        points.for_each(|(at, value)| search.take(at, value));
        let (at, off) = search.best();
        let tolerance = REACHED_REL * self.points[0].1.abs().max(self.points[1].1.abs());
        let next = search.next().filter(|_| off.abs() > 0.1 * tolerance);
        json!({ "next": next, "root": Some(at).filter(|_| off.abs() <= tolerance), "at": at })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_is_found_and_a_step_has_none() {
        let end = |metric: fn(f64) -> f64| {
            let mut search = Target { target: 1.0, points: [0.0, 2.0].map(|at| (at, metric(at))).to_vec() };
            while let Some(next) = search.next()["next"].as_f64() {
                search.points.push((next, metric(next)));
            }
            search.next()
        };
        let (root, step) = (end(|at| at * at), end(|at| if at < 0.3 { 0.0 } else { 2.0 }));
        assert!((root["root"].as_f64().expect("a root") - 1.0).abs() < 1e-4, "{root}");
        assert!(step["root"].is_null() && (step["at"].as_f64().expect("a value") - 0.3).abs() < 1e-5, "{step}");
    }
}
