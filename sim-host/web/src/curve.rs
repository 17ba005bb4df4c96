//! A metric over a key: the points of a curve and the search for a target between two of them.

use serde::Deserialize;
use serde_json::{Value, json};
use sim::study::solve::{REACHED_REL, Search};
use sim::study::{self, Options};

use crate::request::Request;

/// Largest width of the interval of a root, relative to the root.
const ROOT_WIDTH_REL: f64 = 1e-6;

/// A scene and the metric that is read from its run.
#[derive(Clone, Debug, Deserialize)]
pub struct Point {
    /// Scene with the value of the key among its changes.
    #[serde(flatten)]
    pub request: Request,
    /// Name of the metric.
    pub metric: String,
}

impl Point {
    /// Runs the scene. Returns the metric as `value`, or the reason that the run has none as `why`.
    pub fn run(&self) -> Value {
        self.value().map_or_else(|why| json!({ "why": why }), |value| json!({ "value": value }))
    }

    fn value(&self) -> Result<f64, String> {
        let loaded = self.request.load()?;
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

    fn root(target: f64, ends: [f64; 2], metric: impl Fn(f64) -> f64) -> (Value, usize) {
        let mut search = Target { target, points: ends.map(|at| (at, metric(at))).to_vec() };
        while let Some(next) = search.next()["next"].as_f64() {
            search.points.push((next, metric(next)));
        }
        (search.next(), search.points.len())
    }

    /// The closed form of Coulomb friction: a third is left at a velocity ratio of one half.
    #[test]
    fn a_target_is_found_by_single_runs_and_a_step_has_none() {
        let point = |ratio: f64| {
            let sets = vec!["contact.dahl.stiffness_n_per_m=1e12".into(), format!("excitation.velocity_ratio={ratio}")];
            let request = Request { name: "contact-kinematic".into(), sets, ..Request::default() };
            Point { request, metric: "friction_ratio".into() }.run()
        };
        let (end, runs) = root(1.0 / 3.0, [0.2, 0.9], |ratio| point(ratio)["value"].as_f64().expect("a metric"));
        assert!((end["root"].as_f64().expect("a root") - 0.5).abs() < 1e-4 && runs < 12, "{end}");
        assert!(point(-1.0)["why"].as_str().expect("a reason").contains("velocity_ratio"));
        let (end, _) = root(1.0, [0.0, 1.0], |at| if at < 0.3 { 0.0 } else { 2.0 });
        assert!(end["root"].is_null() && (end["at"].as_f64().expect("a value") - 0.3).abs() < 1e-5, "{end}");
    }
}
