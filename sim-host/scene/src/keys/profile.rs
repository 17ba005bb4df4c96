//! A measured value over time: its file and its samples.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A measured value over time, from a table of numbers (`file`) or as samples (`time_s` and
/// `values`). Between two samples it is a straight line. When a scene is loaded, its file is
/// replaced by the samples, so that a run can be repeated without the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Table of numbers with a time column, as CSV; the path is relative to the scene's file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Heading of the column, or its number from 1. Default: the only column other than the time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Unit of the column. Default: from its heading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Heading of the time column, or its number. Default: `t` or `time`; without headings the
    /// first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_column: Option<String>,
    /// Unit of the time. Default: from its heading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_unit: Option<String>,
    /// Time in the file at which playback begins, s.
    #[serde(default)]
    #[schemars(range(min = -1e9, max = 1e9))]
    pub from_s: f64,
    /// File and columns that the samples were read from.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// Time of each sample, s, in ascending order.
    #[serde(default)]
    pub time_s: Arc<[f64]>,
    /// Value of each sample, in the unit of the quantity.
    #[serde(default)]
    pub values: Arc<[f64]>,
}

impl Profile {
    /// Returns the value `since_s` seconds after the beginning of playback, on a straight line
    /// between two samples. Before the first and after the last sample it is constant; without
    /// samples, zero.
    #[inline] // in the loop of a plant, which is compiled for speed; this crate is not
    pub fn at(&self, since_s: f64) -> f64 {
        let time_s = since_s + self.from_s;
        let after = self.time_s.partition_point(|&sample| sample <= time_s);
        let (last, next) = (after.checked_sub(1).and_then(|last| self.sample(last)), self.sample(after));
        match (last, next) {
            (Some((t0, v0)), Some((t1, v1))) => v0 + (v1 - v0) * ((time_s - t0) / (t1 - t0)),
            (Some((_, value)), None) | (None, Some((_, value))) => value,
            (None, None) => 0.0,
        }
    }

    /// Returns the samples from the beginning of playback: time since then, s, and value. The first
    /// is at time zero.
    pub fn played(&self) -> impl Iterator<Item = (f64, f64)> {
        let later = self.time_s.partition_point(|&sample| sample <= self.from_s);
        let samples = (later..self.time_s.len()).filter_map(|index| self.sample(index));
        std::iter::once((0.0, self.at(0.0))).chain(samples.map(|(time_s, value)| (time_s - self.from_s, value)))
    }

    /// Returns the time of the first sample after `since_s`, both in seconds since the beginning of
    /// playback.
    pub fn next_sample(&self, since_s: f64) -> Option<f64> {
        let after = self.time_s.partition_point(|&sample| sample - self.from_s <= since_s);
        self.time_s.get(after).map(|time_s| time_s - self.from_s)
    }

    #[inline]
    fn sample(&self, index: usize) -> Option<(f64, f64)> {
        Some((*self.time_s.get(index)?, *self.values.get(index)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(from_s: f64) -> Profile {
        let (time_s, values) = (Arc::from([1.0, 2.0, 4.0]), Arc::from([10.0, 20.0, 0.0]));
        let none = || None;
        let (file, column, unit, time_column, time_unit) = (none(), none(), none(), none(), none());
        Profile { file, column, unit, time_column, time_unit, from_s, source: String::new(), time_s, values }
    }

    #[test]
    fn values_between_samples_are_linear() {
        let profile = profile(0.0);
        assert_eq!([0.0, 1.0, 1.25, 2.0, 3.0, 4.0, 9.0].map(|time| profile.at(time)), [10.0, 10.0, 12.5, 20.0, 10.0, 0.0, 0.0]);
    }

    #[test]
    fn playback_begins_at_from_s() {
        assert_eq!(profile(1.5).at(0.0), 15.0);
        assert_eq!(profile(1.5).played().collect::<Vec<_>>(), [(0.0, 15.0), (0.5, 20.0), (2.5, 0.0)]);
        assert_eq!(profile(2.0).played().collect::<Vec<_>>(), [(0.0, 20.0), (2.0, 0.0)]);
    }
}
