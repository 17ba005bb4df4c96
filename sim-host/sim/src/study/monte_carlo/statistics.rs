//! Statistics of several runs: typical values and worst cases.
//!
//! | name | definition |
//! |---|---|
//! | `NAME` | median of the runs; for an even number, the mean of the middle two |
//! | `NAME_p95` | smallest value that at least 95 % of the runs do not exceed (nearest rank) |
//! | `NAME_max` | maximum |
//! | `NAME_low95`, `NAME_high95` | ends of the interval that contains 95 % of the runs: 2.5 % are lower, 2.5 % higher |
//!
//! If a metric is [best at zero](Sign::Error), percentile and maximum are those of its absolute
//! value. [Flags](Sign::Flag) are counted. A [code](Sign::Code) is kept if it is the same in all
//! runs. A run that lacks a time counts as infinite: one that never locks has no lock time. An
//! infinite statistic is absent, and `null` in JSON. For any other metric, a run that lacks it is
//! not counted: one that is never steady has no bias. The table of the report states the number of
//! counted runs.

use crate::metrics::Metrics;
use report::statistics::{ascending, median, percentile};
use scene::metrics::{OF_RUNS, Sign, metric};

/// Suffixes of the names of times.
const TIMES: [&str; 2] = ["_ms", "_us"];

/// Part of the runs in an interval.
const INTERVAL: f64 = 0.95;

/// Statistics of several runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Metrics of all runs together.
    pub metrics: Metrics,
    /// Names of the metrics that would be infinite.
    pub endless: Vec<&'static str>,
}

/// Statistics of one metric over all runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Median of the values.
    pub median: f64,
    /// 95th percentile; of the absolute value if the metric is signed.
    pub p95: f64,
    /// Maximum; of the absolute value if the metric is signed.
    pub max: f64,
    /// Ends of the interval that contains 95 % of the values.
    pub interval: [f64; 2],
    /// Number of runs that have the metric, excluding those that count as infinite.
    pub have: usize,
}

/// Computes the statistics of these runs, for each metric that at least one of them has.
pub fn combine<'a>(runs: impl Iterator<Item = &'a Metrics> + Clone) -> Statistics {
    let mut over = Statistics::default();
    for names in OF_RUNS.iter() {
        let name = names.metric.name;
        let mut having = runs.clone().filter_map(|run| run.get(name)).peekable();
        let Some(&first) = having.peek() else { continue };
        match names.metric.sign {
            Sign::Flag => over.put(name, having.sum::<f64>()),
            Sign::Code if having.all(|value| value == first) => over.put(name, first),
            Sign::Code | Sign::Count => {}
            Sign::Magnitude | Sign::Signed | Sign::Error => {
                let Some(spread) = spread(name, runs.clone()) else { continue };
                over.put(name, spread.median);
                over.put(&names.p95, spread.p95);
                over.put(&names.max, spread.max);
                over.put(&names.low95, spread.interval[0]);
                over.put(&names.high95, spread.interval[1]);
            }
        }
    }
    over
}

impl Statistics {
    fn put(&mut self, name: &'static str, value: f64) {
        if value.is_infinite() {
            self.endless.push(name);
        }
        self.metrics.put(name, value);
    }
}

/// Computes the statistics of these values; NaN if there are none.
pub fn spread_of(values: Vec<f64>) -> Spread {
    let (values, have) = (ascending(values.iter().copied()), values.len());
    let [p95, max] = [0.95, 1.0].map(|part| percentile(&values, part));
    Spread { median: median(&values), p95, max, interval: interval(&values), have }
}

/// Returns the ends of the interval that contains 95 % of ascending numbers.
fn interval(values: &[f64]) -> [f64; 2] {
    [0.5 * (1.0 - INTERVAL), 0.5 * (1.0 + INTERVAL)].map(|part| percentile(values, part))
}

/// Computes the statistics of one metric of these runs, if any of them has it.
pub fn spread<'a>(name: &str, runs: impl Iterator<Item = &'a Metrics>) -> Option<Spread> {
    let time = TIMES.iter().any(|end| name.ends_with(end));
    let all: Vec<Option<f64>> = runs.map(|run| run.get(name)).collect();
    let have = all.iter().flatten().count();
    if have == 0 {
        return None;
    }
    let mut values = ascending(all.into_iter().filter_map(|value| value.or(time.then_some(f64::INFINITY))));
    let (median, interval) = (median(&values), interval(&values));
    if metric(name).is_some_and(|metric| metric.sign == Sign::Error) {
        values = ascending(values.into_iter().map(f64::abs));
    }
    Some(Spread { median, p95: percentile(&values, 0.95), max: percentile(&values, 1.0), interval, have })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(metrics: &[(&'static str, f64)]) -> Metrics {
        let mut run = Metrics::default();
        metrics.iter().for_each(|&(name, value)| run.put(name, value));
        run
    }

    fn over(name: &'static str, values: &[Option<f64>]) -> Statistics {
        let runs: Vec<Metrics> =
            values.iter().map(|value| run(&value.map(|v| (name, v)).into_iter().collect::<Vec<_>>())).collect();
        combine(runs.iter())
    }

    #[test]
    fn percentiles_are_nearest_ranks() {
        let twenty: Vec<Option<f64>> = (1..=20).rev().map(|n| Some(f64::from(n))).collect();
        let found = over("lock_time_20hz_ms", &twenty).metrics;
        assert_eq!(found.get("lock_time_20hz_ms"), Some(10.5));
        assert_eq!(found.get("lock_time_20hz_ms_p95"), Some(19.0));
        assert_eq!(found.get("lock_time_20hz_ms_max"), Some(20.0));
        // Of 19 runs, 18 are less than 95 %.
        let found = over("lock_time_20hz_ms", &twenty[1..]).metrics;
        assert_eq!((found.get("lock_time_20hz_ms"), found.get("lock_time_20hz_ms_p95")), (Some(10.0), Some(19.0)));
        let one = over("q", &[Some(65.0)]).metrics;
        assert_eq!(["q", "q_p95", "q_max", "q_low95", "q_high95"].map(|name| one.get(name)), [Some(65.0); 5]);
    }

    /// If one run of 20 never locks, the maximum and the end of the interval are infinite; with two
    /// the 95th percentile is too, with ten the median.
    #[test]
    fn missing_times_count_as_infinite() {
        let missing = |count: usize| {
            let values: Vec<_> = (0..20).map(|n| (n >= count).then_some(1.0)).collect();
            over("lock_time_4hz_ms", &values).endless
        };
        assert_eq!(missing(0), [""; 0]);
        let of = ["lock_time_4hz_ms", "lock_time_4hz_ms_p95", "lock_time_4hz_ms_max", "lock_time_4hz_ms_high95"];
        assert_eq!(missing(1), of[2..]);
        assert_eq!(missing(2), of[1..]);
        assert_eq!(missing(10), of);
        let found = over("lock_time_4hz_ms", &[Some(1.0), Some(2.0), None]).metrics;
        assert_eq!([found.get("lock_time_4hz_ms"), found.get("lock_time_4hz_ms_max")], [Some(2.0), None]);
        // If no run has the metric, there was nothing to lock to.
        assert_eq!(over("relock_time_4hz_ms", &[None, None]), Statistics::default());
    }

    #[test]
    fn error_metrics_use_absolute_values() {
        let found = over("frequency_bias_hz", &[Some(-3.0), Some(1.0), Some(2.0), None]).metrics;
        let names = ["frequency_bias_hz", "frequency_bias_hz_p95", "frequency_bias_hz_max"];
        assert_eq!(names.map(|name| found.get(name)), [Some(1.0), Some(3.0), Some(3.0)]);
        let found = over("friction_ratio", &[Some(-3.0), Some(1.0)]).metrics;
        assert_eq!(found.get("friction_ratio_max"), Some(1.0));
    }

    #[test]
    fn runs_are_counted() {
        let found = over("false_locks", &[Some(1.0), Some(0.0), Some(1.0), None]).metrics;
        assert_eq!((found.get("false_locks"), found.get("false_locks_p95")), (Some(2.0), None));
        let found = over("plant_states", &[Some(7.0), Some(7.0)]).metrics;
        assert_eq!((found.get("plant_states"), found.get("plant_states_p95")), (Some(7.0), None));
    }

    #[test]
    fn a_code_has_no_median() {
        assert_eq!(over("fault_code", &[Some(0.0), Some(0.0)]).metrics.get("fault_code"), Some(0.0));
        assert_eq!(over("fault_code", &[Some(0.0), Some(31.0)]), Statistics::default());
    }
}
