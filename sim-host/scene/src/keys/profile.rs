//! A value over time, as it was measured: where it is read from, and its samples.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A measured value over time, from a table of numbers (`file`) or as samples (`time_s` and `values`). Between two samples it runs along a
/// straight line. A scene that has been read has the samples, so that a run can be repeated without the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Table of numbers with a column of time, as CSV; beside the file of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Heading of the column, or its number from 1. Default: the only one beside the time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Unit of the column. Default: as its heading says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Heading of the column of time, or its number. Default: the one that is called `t` or `time`; without headings the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_column: Option<String>,
    /// Unit of the time. Default: as its heading says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_unit: Option<String>,
    /// Time in the file, s, from which on it is played.
    #[serde(default)]
    #[schemars(range(min = -1e9, max = 1e9))]
    pub from_s: f64,
    /// File and columns that the samples were read from.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// Time of each sample, s, in ascending order.
    #[serde(default)]
    pub time_s: Arc<[f64]>,
    /// Value of each sample, in the unit of what it is the course of.
    #[serde(default)]
    pub values: Arc<[f64]>,
}

impl Profile {
    /// The value so many seconds after the profile began to play, along a straight line between two samples; before the first and after the last
    /// sample their values. Zero without samples.
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

    /// Time since the profile began to play, s, and value of the samples from that moment on, the first of them at zero.
    pub fn played(&self) -> impl Iterator<Item = (f64, f64)> {
        let later = self.time_s.partition_point(|&sample| sample <= self.from_s);
        let samples = (later..self.time_s.len()).filter_map(|index| self.sample(index));
        std::iter::once((0.0, self.at(0.0))).chain(samples.map(|(time_s, value)| (time_s - self.from_s, value)))
    }

    /// When the first sample comes after so many seconds of playing, in seconds since the profile began to play.
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
    fn between_samples_it_is_a_straight_line() {
        let profile = profile(0.0);
        assert_eq!([0.0, 1.0, 1.25, 2.0, 3.0, 4.0, 9.0].map(|time| profile.at(time)), [10.0, 10.0, 12.5, 20.0, 10.0, 0.0, 0.0]);
    }

    #[test]
    fn it_is_played_from_a_moment_on() {
        assert_eq!(profile(1.5).at(0.0), 15.0);
        assert_eq!(profile(1.5).played().collect::<Vec<_>>(), [(0.0, 15.0), (0.5, 20.0), (2.5, 0.0)]);
        assert_eq!(profile(2.0).played().collect::<Vec<_>>(), [(0.0, 20.0), (2.0, 0.0)]);
    }
}
