//! Plant values that change during a run: steps, ramps, sines and measured profiles, from a scene's
//! `[[disturbance]]`.

use scene::{Disturbance, DisturbedKey};

/// One change in progress.
#[derive(Clone, Debug)]
pub struct Change {
    disturbance: Disturbance,
    /// Sum that a ramp or a sine has added so far. Only the difference is added next, so that
    /// changes of one key add up.
    added: f64,
    done: bool,
}

impl Change {
    /// Creates a change that has not begun.
    pub fn new(disturbance: Disturbance) -> Self {
        Change { disturbance, added: 0.0, done: false }
    }

    /// Returns the key of the scene whose value changes.
    pub fn key(&self) -> DisturbedKey {
        self.disturbance.key
    }

    /// Returns `true` if it makes no further changes.
    pub fn is_over(&self) -> bool {
        self.done
    }

    /// Returns the key's next value at `time_s`, if this change affects it; `present` is its value
    /// so far.
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
        if let Some(profile) = &change.profile {
            return Some(profile.at(since));
        }
        let turns = change.sine_hz.unwrap_or(0.0) * since;
        let sine = change.sine_amplitude.unwrap_or(0.0) * libm::sin(std::f64::consts::TAU * turns);
        let added = change.rate_per_s.unwrap_or(0.0) * since + sine;
        Some(present + added - std::mem::replace(&mut self.added, added))
    }
}

#[cfg(test)]
mod tests {
    use super::Change;
    use scene::load::load;

    #[test]
    fn a_measured_profile_is_followed() {
        let profile = "disturbance.0={at_s=0.1, key=\"rig.slider.speed_m_per_s\", profile={from_s=2, time_s=[1,3,5], values=[0.01,0.03,0.02]}}";
        let loaded = load("belt-stop-slow", &[profile.to_owned()]).unwrap_or_else(|error| panic!("{error}"));
        let mut change = Change::new(loaded.scene.disturbance[0].clone());
        assert_eq!(change.next(0.05, 0.038), None);
        for (time_s, speed) in [(0.1, 0.02), (0.2, 0.021), (1.1, 0.03), (2.1, 0.025)] {
            let next = change.next(time_s, 0.038).unwrap();
            assert!((next - speed).abs() < 1e-12 && !change.is_over(), "{time_s}: {next}");
        }
    }
}
