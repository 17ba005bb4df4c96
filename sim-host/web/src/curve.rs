//! A metric over a key: the points of a curve and the search for a target between two of them.

use scene::load::Loaded;
use serde::Deserialize;
use serde_json::{Value, json};
use sim::study::solve::{REACHED_REL, Search};
use sim::study::{self, Options, Study};

use crate::request::Request;

/// Largest number of points of a search.
const MAX_POINTS: usize = 24;

/// Returns the fault that ended a single run, unless the scene expects it.
pub(crate) fn fault(study: &Study) -> Option<f64> {
    let expected = study.judged.iter().any(|judged| judged.metric == "fault_code" && judged.pass);
    study.metrics.find("fault_code").filter(|code| *code != 0.0 && study.scene.runs == 1 && !expected)
}

impl Request {
    /// Runs the scene. Returns the requested metric.
    ///
    /// # Errors
    /// The reason that the run has none.
    pub fn point(&self) -> Result<f64, String> {
        // As many runs at each point: a jump of the number would be a jump of the metric.
        let loaded = Loaded { default_runs: false, ..self.load()? };
        let study = study::run(&loaded, Options::default()).map_err(|error| error.to_string())?;
        match fault(&study) {
            Some(code) => Err(format!("the run ends in fault {code}")),
            None => study.metrics.find(&self.metric).filter(|value| value.is_finite()).ok_or("the run has no such number".into()),
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
        let mut search = Search::new(low, high);
        points.for_each(|(at, value)| search.take(at, value));
        let (at, off) = search.best();
        let tolerance = REACHED_REL * self.points[0].1.abs().max(self.points[1].1.abs());
        let next = search.next().filter(|_| off.abs() > 0.1 * tolerance && self.points.len() < MAX_POINTS);
        json!({ "next": next, "root": Some(at).filter(|_| off.abs() <= tolerance), "at": at })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_has_no_root() {
        let step = |at: f64| (at, if at < 0.3 { 0.0 } else { 2.0 });
        let mut search = Target { target: 1.0, points: vec![step(0.0), step(1.0)] };
        while let Some(next) = search.next()["next"].as_f64() {
            search.points.push(step(next));
        }
        let end = search.next();
        assert!(end["root"].is_null() && (end["at"].as_f64().expect("a value") - 0.3).abs() < 1e-5, "{end}");
    }
}
