//! Metrics of a study, by the names of the [table of metrics](scene::metrics). A metric that does
//! not apply to a study is absent, never zero.

use scene::metrics::{rank, renamed};

/// Named metrics, in the order of the table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metrics(Vec<(&'static str, f64)>);

impl Metrics {
    /// Returns the value of a metric, if this study has it.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(have, _)| *have == name).map(|&(_, value)| value)
    }

    /// Returns the value of a metric by its name or, if this study lacks it, by its former name.
    pub fn find(&self, name: &str) -> Option<f64> {
        self.get(name).or_else(|| self.get(renamed(name)?))
    }

    /// Iterates over all metrics, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.0.iter().copied()
    }

    /// Adds a metric of the table, if it has a finite value.
    pub(crate) fn put(&mut self, name: &'static str, value: impl Into<Option<f64>>) {
        debug_assert!(rank(name).is_some(), "the table of metrics has no `{name}`");
        if let Some(value) = value.into().filter(|value| value.is_finite()) {
            let place = self.0.partition_point(|(other, _)| rank(other) <= rank(name));
            self.0.insert(place, (name, value));
        }
    }
}
