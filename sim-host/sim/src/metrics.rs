//! Numbers from a study. Names are a contract (units last); what cannot be said of a study is left out, never zero. What each one means
//! stands with the [instrument](crate::instruments) that measures it.

use scene::metric_names::rank;

/// Named numbers, in the order of [`NAMES`](scene::metric_names::NAMES).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metrics(Vec<(&'static str, f64)>);

impl Metrics {
    /// The value of a metric, if this study has it.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(have, _)| *have == name).map(|&(_, value)| value)
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.0.iter().copied()
    }

    /// The same without one of them.
    pub(crate) fn without(mut self, name: &str) -> Self {
        self.0.retain(|(have, _)| *have != name);
        self
    }

    pub(crate) fn put(&mut self, name: &'static str, value: impl Into<Option<f64>>) {
        if let Some(value) = value.into().filter(|value| value.is_finite()) {
            let place = self.0.partition_point(|(other, _)| rank(other) <= rank(name));
            self.0.insert(place, (name, value));
        }
    }
}
