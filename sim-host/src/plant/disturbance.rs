//! Plant values that change on the way: steps, ramps and sines, from a scene's `[[disturbance]]`.

use crate::scene::{Disturbance, DisturbedKey};

/// One change, with the value that the key had when it began.
#[derive(Clone, Debug)]
pub struct Change {
    disturbance: Disturbance,
    /// Value at the beginning; `None` before.
    base: Option<f64>,
    done: bool,
}

impl Change {
    /// A change that has not begun.
    pub fn new(disturbance: Disturbance) -> Self {
        Change { disturbance, base: None, done: false }
    }

    /// What changes.
    pub fn key(&self) -> DisturbedKey {
        self.disturbance.key
    }

    /// Whether it has nothing more to say.
    pub fn is_over(&self) -> bool {
        self.done
    }

    /// The key's value at `time_s`, if this change sets it now; `present` is what it is so far.
    pub fn value(&mut self, time_s: f64, present: f64) -> Option<f64> {
        let since = time_s - self.disturbance.at_s;
        if since < 0.0 || self.done {
            return None;
        }
        let change = &self.disturbance;
        if change.to.is_some() {
            self.done = true;
            return change.to;
        }
        let base = *self.base.get_or_insert(present);
        let ramp = change.rate_per_s.unwrap_or(0.0) * since;
        let turns = change.sine_hz.unwrap_or(0.0) * since;
        Some(base + ramp + change.sine_amplitude.unwrap_or(0.0) * libm::sin(std::f64::consts::TAU * turns))
    }
}
