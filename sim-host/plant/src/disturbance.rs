//! Plant values that change on the way: steps, ramps and sines, from a scene's `[[disturbance]]`.

use scene::{Disturbance, DisturbedKey};

/// One change on its way.
#[derive(Clone, Debug)]
pub struct Change {
    disturbance: Disturbance,
    /// What a ramp or a sine has added so far. Only the difference is added next, so that changes of one key add up.
    added: f64,
    done: bool,
}

impl Change {
    /// A change that has not begun.
    pub fn new(disturbance: Disturbance) -> Self {
        Change { disturbance, added: 0.0, done: false }
    }

    /// Key of the scene whose value changes.
    pub fn key(&self) -> DisturbedKey {
        self.disturbance.key
    }

    /// Whether it has nothing more to say.
    pub fn is_over(&self) -> bool {
        self.done
    }

    /// The key's next value at `time_s`, if this change moves it; `present` is what it is so far.
    pub fn next(&mut self, time_s: f64, present: f64) -> Option<f64> {
        let change = &self.disturbance;
        let since = time_s - change.at_s;
        if since < 0.0 || self.done {
            return None;
        }
        if change.to.is_some() {
            self.done = true;
            return change.to;
        }
        let turns = change.sine_hz.unwrap_or(0.0) * since;
        let sine = change.sine_amplitude.unwrap_or(0.0) * libm::sin(std::f64::consts::TAU * turns);
        let added = change.rate_per_s.unwrap_or(0.0) * since + sine;
        Some(present + added - std::mem::replace(&mut self.added, added))
    }
}
