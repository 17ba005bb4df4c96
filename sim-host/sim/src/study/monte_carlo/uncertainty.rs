//! Uncertainty of the main result of several runs: its interval, and the part of its variance that
//! each drawn number explains.
//!
//! The metric is fitted by an additive polynomial, `y = c + sum over keys of f_k(x_k)`, with
//! Legendre polynomials of the rank of each drawn number among the runs. The part of a key is the
//! variance of its `f_k`, relative to that of the metric: its first-order Sobol' index (Sobol'
//! 1993). The rest is due to interactions of the keys, and to noise. Keys that are drawn together
//! have one part, with their products. The expected part that noise adds to a fit is subtracted.

use super::{MonteCarlo, OneRun, statistics};
use crate::instruments::{self, Line};
use crate::study::contact::table;
use crate::study::design;
use report::rounded_to;
use report::statistics::ascending;
use scene::Scene;

/// Highest degree of a polynomial.
const MAX_DEGREE: usize = 4;
/// Number of runs for each fitted number.
const RUNS_PER_COEFFICIENT: usize = 10;
/// Largest standard error of an end of an interval, relative to its width, for which no more runs
/// are made.
pub const END_ERROR_REL: f64 = 0.1;
/// Number of headline intervals.
const INTERVALS: usize = 3;
/// Number of passes of the fit.
const PASSES: usize = 100;

/// Smallest width of an interval that is written with decimals.
const MIN_DECIMAL: f64 = 1e-4;
/// Lock times, which the headline of a single run does not have.
pub const LOCK: [Line; 2] = [("lock time to 20 Hz", "lock_time_20hz_ms", "ms"), ("lock time to 4 Hz", "lock_time_4hz_ms", "ms")];
/// Friction ratio, which the headline of a single run has with its numerical error.
const FRICTION_RATIO: Line = ("friction ratio", "friction_ratio", "");

/// Interval of a metric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Label, metric and unit.
    pub line: Line,
    /// Median of the runs.
    pub median: f64,
    /// Ends of the interval that contains 95 % of the runs.
    pub ends: [f64; 2],
}

impl Interval {
    /// Formats the median and the interval, with two digits of the width.
    pub fn text(&self) -> String {
        let [low, high] = self.ends;
        let round = |value: f64| match high - low {
            width if width < MIN_DECIMAL => format!("{value:.2e}"),
            width => rounded_to(value, width),
        };
        let unit = self.line.2;
        let blank = if unit.is_empty() { "" } else { " " };
        format!("{}{blank}{unit} (95 %: {} to {})", round(self.median), round(low), round(high))
    }
}

/// Parts of the variance of a metric.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares {
    /// Keys that are drawn together, and their part; the largest first.
    pub keys: Vec<(Vec<String>, f64)>,
    /// Part that no key explains by itself.
    pub rest: f64,
}

/// Returns the main metrics of a scene, the most important first: those of its expectations, which
/// are its question, then those of a single run.
pub fn lines(scene: &Scene) -> Vec<Line> {
    let contact = || table::HEADLINE[..1].iter().copied().chain([FRICTION_RATIO]).chain(table::HEADLINE[1..].iter().copied());
    let mut lines: Vec<Line> = match (&scene.controller, &scene.design) {
        (Some(_), _) => LOCK.into_iter().chain(instruments::headline()).collect(),
        (_, Some(_)) => design::table::HEADLINE.to_vec(),
        _ => contact().collect(),
    };
    let is_of = |metric: &str, line: &Line| metric.strip_prefix(line.1).is_some_and(|rest| ["", "_p95", "_max"].contains(&rest));
    lines.sort_by_key(|line| !scene.expect.iter().any(|expect| is_of(&expect.metric, line)));
    if scene.expect.is_empty() {
        lines.retain(|line| !LOCK.contains(line));
    }
    lines
}

/// Returns the larger standard error of the two ends of the main interval, relative to its width:
/// half the distance between the values one standard deviation of the rank below and above the end.
/// `None` without an interval. For an even sequence of draws it is an upper bound.
pub fn end_error_rel(scene: &Scene, runs: &[OneRun]) -> Option<f64> {
    let interval = of_runs(scene, runs).into_iter().next()?;
    let values = ascending(runs.iter().filter_map(|run| run.metrics.get(interval.line.1)));
    let (last, count) = (values.len() as f64 - 1.0, values.len() as f64);
    let error = |part: f64| {
        let (rank, sigma) = (part * last, (count * part * (1.0 - part)).sqrt());
        let at = |rank: f64| values[rank.round().clamp(0.0, last) as usize];
        0.5 * (at(rank + sigma) - at(rank - sigma))
    };
    Some(error(0.025).max(error(0.975)) / (interval.ends[1] - interval.ends[0]))
}

/// Returns the intervals of the main metrics that differ between the runs.
pub fn intervals(scene: &Scene, runs: &MonteCarlo) -> Vec<Interval> {
    of_runs(scene, &runs.runs)
}

fn of_runs(scene: &Scene, runs: &[OneRun]) -> Vec<Interval> {
    let interval = |line: Line| {
        let spread = statistics::spread(line.1, runs.iter().map(|run| &run.metrics))?;
        let finite = spread.interval.iter().all(|end| end.is_finite()) && spread.interval[0] < spread.interval[1];
        finite.then_some(Interval { line, median: spread.median, ends: spread.interval })
    };
    lines(scene).into_iter().filter_map(interval).take(INTERVALS).collect()
}

/// Returns the parts of the variance of a metric; `None` without drawn keys, or if there are too
/// few runs.
pub fn shares(scene: &Scene, runs: &MonteCarlo, metric: &str) -> Option<Shares> {
    let having: Vec<(&Vec<f64>, f64)> =
        runs.runs.iter().filter_map(|run| Some((&run.draw.values, run.metrics.get(metric)?))).collect();
    let mut sets: Vec<(String, Vec<usize>)> = Vec::new();
    for (place, vary) in scene.vary.iter().enumerate() {
        let name = vary.set.as_ref().unwrap_or(&vary.key);
        match sets.iter_mut().find(|(known, _)| known == name) {
            Some((_, places)) => places.push(place),
            None => sets.push((name.clone(), vec![place])),
        }
    }
    let degree = (having.len() / (RUNS_PER_COEFFICIENT * runs.keys.len().max(1))).min(MAX_DEGREE);
    if degree == 0 || sets.is_empty() {
        return None;
    }
    let columns: Vec<Vec<Vec<f64>>> = sets
        .iter()
        .map(|(_, places)| {
            let column = |&place: &usize| legendre(&ranks(having.iter().map(|(values, _)| values[place]).collect()), degree);
            let pairs = places.iter().enumerate().flat_map(|(n, a)| places[n + 1..].iter().map(move |b| (a, b)));
            let product = |(a, b): (&usize, &usize)| {
                let [a, b] = [a, b].map(|&place| ranks(having.iter().map(|(values, _)| values[place]).collect()));
                centred(a.iter().zip(&b).map(|(a, b)| a * b).collect())
            };
            places.iter().flat_map(column).chain(pairs.map(product)).collect()
        })
        .collect();
    let mut rest = centred(having.iter().map(|(_, value)| *value).collect());
    let total = dot(&rest, &rest);
    if total == 0.0 || !total.is_finite() {
        return None;
    }
    // Least squares, one coefficient at a time: the columns are nearly orthogonal.
    let mut parts = vec![vec![0.0; having.len()]; sets.len()];
    for _ in 0..PASSES {
        for (columns, part) in columns.iter().zip(&mut parts) {
            for column in columns {
                let step = dot(&rest, column) / dot(column, column).max(f64::MIN_POSITIVE);
                for ((rest, part), x) in rest.iter_mut().zip(part.iter_mut()).zip(column) {
                    (*rest, *part) = (*rest - step * x, *part + step * x);
                }
            }
        }
    }
    let named = |(_, places): (String, Vec<usize>)| places.into_iter().map(|place| scene.vary[place].key.clone()).collect();
    let fitted: usize = columns.iter().map(Vec::len).sum();
    let noise = dot(&rest, &rest) / total / having.len().saturating_sub(fitted + 1).max(1) as f64;
    let part = |(part, columns): (&Vec<f64>, &Vec<Vec<f64>>)| (dot(part, part) / total - columns.len() as f64 * noise).max(0.0);
    let mut keys: Vec<(Vec<String>, f64)> = sets.into_iter().map(named).zip(parts.iter().zip(&columns).map(part)).collect();
    keys.sort_by(|a, b| b.1.total_cmp(&a.1));
    let rest = (1.0 - keys.iter().map(|(_, part)| part).sum::<f64>()).max(0.0);
    Some(Shares { keys, rest })
}

/// Returns the ranks of numbers, evenly from -1 to 1. Equal numbers have their mean rank.
fn ranks(values: Vec<f64>) -> Vec<f64> {
    let sorted = ascending(values.iter().copied());
    let rank = |value: &f64| {
        let (below, upto) = (sorted.partition_point(|other| other < value), sorted.partition_point(|other| other <= value));
        (below + upto) as f64 / sorted.len() as f64 - 1.0
    };
    values.iter().map(rank).collect()
}

/// Returns the centred Legendre polynomials of degree 1 and higher.
fn legendre(x: &[f64], degree: usize) -> Vec<Vec<f64>> {
    let (mut before, mut last) = (vec![1.0; x.len()], x.to_vec());
    let mut all = Vec::with_capacity(degree);
    for n in 1..=degree {
        all.push(centred(last.clone()));
        let (a, b) = ((2 * n + 1) as f64 / (n + 1) as f64, n as f64 / (n + 1) as f64);
        let next = x.iter().zip(last.iter().zip(&before)).map(|(x, (last, before))| a * x * last - b * before).collect();
        (before, last) = (last, next);
    }
    all
}

fn centred(values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.into_iter().map(|value| value - mean).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Metrics;
    use crate::study::driven::Level;
    use crate::study::monte_carlo::OneRun;
    use crate::study::monte_carlo::draw::Draws;
    use scene::load::load_text;

    /// Runs of a kinematic contact with uniform `mu` and stiffness in 0 to 1 of their ranges, and a
    /// function of them as the reduction.
    fn of(function: fn(f64, f64) -> f64) -> (Scene, MonteCarlo) {
        let text = "base = \"contact-kinematic\"\ngrid = false\nruns = 512\n[contact.dahl]\nmu = { low = 0.1, high = 1.1 }\n\
                    stiffness_n_per_m = { low = 1e6, high = 2e6 }";
        let scene = load_text("test", text, &[]).unwrap_or_else(|error| panic!("{error}")).scene;
        let draws = Draws::of(&scene);
        let run = |number: u32| {
            let (draw, mut metrics) = (draws.draw(number), Metrics::default());
            metrics.put("reduction_percent", function(draw.values[0] - 0.1, 1e-6 * draw.values[1] - 1.0));
            OneRun { draw, metrics, locked: false, drive_hash: None, error_hz: Vec::new() }
        };
        let runs =
            MonteCarlo { keys: draws.keys.clone(), level: Level::Sil, runs: (1..=512).map(run).collect(), ..MonteCarlo::none() };
        (scene, runs)
    }

    /// For `y = a + b^2 / 2 + c (a - 1/2) (b - 1/2)` the parts are known: variances 1/12, 1/45 and
    /// c^2 / 144.
    #[test]
    fn parts_of_the_variance_are_those_of_the_function() {
        let (scene, runs) = of(|a, b| a + 0.5 * b * b + 2.0 * (a - 0.5) * (b - 0.5));
        let shares = shares(&scene, &runs, "reduction_percent").unwrap();
        let total = 1.0 / 12.0 + 1.0 / 45.0 + 4.0 / 144.0;
        let part = |key: &str| shares.keys.iter().find(|(keys, _)| keys[0] == key).unwrap().1;
        for (found, truth) in [
            (part("contact.dahl.mu"), 1.0 / 12.0 / total),
            (part("contact.dahl.stiffness_n_per_m"), 1.0 / 45.0 / total),
            (shares.rest, 4.0 / 144.0 / total),
        ] {
            assert!((found - truth).abs() < 0.02, "{found} for {truth}: {shares:?}");
        }
    }

    /// A metric that no key changes, and one that two keys of the same rows determine.
    #[test]
    fn noise_is_rest_and_a_set_has_one_part() {
        let (scene, runs) = of(|a, b| (1e6 * (a + 3.0 * b)).sin());
        let noise = shares(&scene, &runs, "reduction_percent").unwrap();
        assert!(noise.rest > 0.98, "{noise:?}");
        let (mut scene, runs) = of(|a, b| (a - 0.5) * (b - 0.5));
        scene.vary.iter_mut().for_each(|vary| vary.set = Some("fit.csv".into()));
        let together = shares(&scene, &runs, "reduction_percent").unwrap();
        assert!(together.keys.len() == 1 && together.keys[0].1 > 0.99, "{together:?}");
    }

    #[test]
    fn the_interval_has_the_quantiles() {
        let (scene, runs) = of(|a, _| 100.0 * a);
        let interval = intervals(&scene, &runs)[0];
        assert!((interval.median - 50.0).abs() < 0.5 && (interval.ends[0] - 2.5).abs() < 0.5, "{interval:?}");
        assert!(interval.text().starts_with("50 % (95 %: 2 to 9"), "{}", interval.text());
    }
}
