//! A metric over a key: the points of a curve and the search for a target between two of them.

use serde::Deserialize;
use serde_json::{Value, json};
use sim::study::solve::{REACHED_REL, Search};
use sim::study::{self, Options};

use crate::request::Request;

/// Largest width of the interval of a root, relative to the root.
const ROOT_WIDTH_REL: f64 = 1e-6;
/// Part of [`REACHED_REL`] at which a search ends.
const CLOSE: f64 = 0.1;

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
    /// Runs the scene. Returns the metric, or the reason that the run has none, as in a sweep.
    pub fn run(&self) -> Value {
        match self.value() {
            Ok(value) => json!({ "value": value }),
            Err(why) => json!({ "why": why }),
        }
    }

    fn value(&self) -> Result<f64, String> {
        let loaded = self.request.load()?;
        let study = study::run(&loaded, Options::default()).map_err(|error| error.to_string())?;
        match study.metrics.find("fault_code").filter(|code| *code != 0.0 && loaded.scene.runs == 1) {
            Some(code) => Err(format!("the run ends in fault {code}")),
            None => study
                .metrics
                .find(&self.metric)
                .filter(|value| value.is_finite())
                .ok_or_else(|| "the run has no such number".to_owned()),
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
        let off = |&(at, metric): &(f64, f64)| (at, metric - self.target);
        let [low, high, further @ ..] = &self.points[..] else { return Value::Null };
        let mut search = Search::new(off(low), off(high), ROOT_WIDTH_REL);
        for (at, value) in further.iter().map(off) {
            search.take(at, value);
        }
        let (at, distance) = search.best();
        let tolerance = REACHED_REL * low.1.abs().max(high.1.abs());
        let next = search.next().filter(|_| distance.abs() > CLOSE * tolerance);
        let root = Some(at).filter(|_| next.is_none() && distance.abs() <= tolerance);
        json!({ "next": next, "root": root, "at": at })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(sets: &[&str]) -> Value {
        let sets = sets.iter().map(|&set| set.to_owned()).collect();
        let request = Request { name: "contact-kinematic".into(), sets, ..Request::default() };
        Point { request, metric: "friction_ratio".into() }.run()
    }

    /// The closed form of Coulomb friction: a third is left at a velocity ratio of one half.
    #[test]
    fn the_target_is_found_by_single_runs() {
        let metric = |ratio: f64| {
            let found = point(&["contact.dahl.stiffness_n_per_m=1e12", &format!("excitation.velocity_ratio={ratio}")]);
            found["value"].as_f64().unwrap_or_else(|| panic!("{found}"))
        };
        let mut search = Target { target: 1.0 / 3.0, points: [0.2, 0.9].map(|ratio| (ratio, metric(ratio))).to_vec() };
        while let Some(next) = search.next()["next"].as_f64() {
            search.points.push((next, metric(next)));
        }
        let end = search.next();
        assert!((end["root"].as_f64().unwrap() - 0.5).abs() < 1e-4 && search.points.len() < 12, "{end} {search:?}");
    }

    #[test]
    fn a_step_has_no_root_and_a_mistake_has_a_reason() {
        let step = |at: f64| (at, if at < 0.3 { 0.0 } else { 2.0 });
        let mut search = Target { target: 1.0, points: vec![step(0.0), step(1.0)] };
        while let Some(next) = search.next()["next"].as_f64() {
            search.points.push(step(next));
        }
        let end = search.next();
        assert!(end["root"].is_null() && (end["at"].as_f64().unwrap() - 0.3).abs() < 1e-5, "{end}");
        assert!(point(&["excitation.velocity_ratio=-1"])["why"].as_str().unwrap().contains("velocity_ratio"));
    }
}
