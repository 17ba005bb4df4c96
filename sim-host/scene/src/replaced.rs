//! Numbers of a scene that another part of the scene replaces before they have an effect.

use super::Scene;

/// Part of a scene that replaces a number before it has an effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Replaced {
    /// Path of the part, for example `vary.0.to`.
    pub by: String,
    /// Predicate of a sentence about the number's key.
    pub why: String,
    /// Advice to the user.
    pub help: String,
}

impl Scene {
    /// Returns the part that replaces a number in every run; `others` are keys that change with it.
    pub fn replaced(&self, key: &str, others: &[&str]) -> Option<Replaced> {
        self.drawn(key).or_else(|| self.replaced_in_time(key, others))
    }

    /// Returns a note if other numbers change with these keys: a velocity ratio ties the sliding
    /// speed to the vibration.
    pub fn coupled(&self, keys: &[&str]) -> Option<String> {
        const OF_THE_VIBRATION: [&str; 4] =
            ["rig.kinematic.vibration_", "rig.sdof.", "excitation.force_n", "excitation.frequency_hz"];
        let ratio = self.excitation.as_ref()?.velocity_ratio?;
        let is_prescribed =
            self.rig.as_ref()?.kinematic.as_ref().is_some_and(|kinematic| kinematic.vibration_amplitude_m.is_none());
        let moves = |key: &&&str| {
            OF_THE_VIBRATION.iter().any(|start| key.starts_with(start)) && !(is_prescribed && key.starts_with("excitation."))
        };
        let key = keys.iter().find(moves).filter(|_| !keys.contains(&"excitation.velocity_ratio"))?;
        Some(format!(
            "`{key}` also changes the sliding speed, which is {} times the vibration velocity (`excitation.velocity_ratio`); \
             `--set excitation.sliding_m_per_s=…` keeps it",
            crate::shown(ratio)
        ))
    }

    /// Returns the entry of `[[vary]]` that draws a number without regard to its own value.
    pub(super) fn drawn(&self, key: &str) -> Option<Replaced> {
        let number = self
            .vary
            .iter()
            .position(|vary| vary.key == key && (vary.from.is_some() || vary.samples.is_some()))
            .filter(|_| self.runs > 1)?;
        Some(Replaced {
            by: format!("vary.{number}.{}", if self.vary[number].from.is_some() { "to" } else { "samples" }),
            why: "is drawn in each run, by its distribution or [[vary]]".to_owned(),
            help: "remove it here (`grid = false` removes a grid), or give it a number and no [[vary]] (`vary = []` removes all \
                   entries); `spread` and `factor` vary about the value of the scene"
                .to_owned(),
        })
    }

    /// Returns the `[[disturbance]]` that replaces a number from the beginning of the run.
    pub(super) fn replaced_in_time(&self, key: &str, others: &[&str]) -> Option<Replaced> {
        let begins_at_once = |number: usize| {
            let at_s = format!("disturbance.{number}.at_s");
            !others.contains(&at_s.as_str()) && self.vary.iter().all(|vary| vary.key != at_s)
        };
        let mut changes = self.disturbance.iter().enumerate();
        let (number, change) = changes.find(|(number, change)| change.replaces(key) && begins_at_once(*number))?;
        let (by, why, what) = match change.profile {
            Some(_) => ("profile", "follows the measured", "profile.from_s"),
            None => ("to", "has the value of", "to"),
        };
        let entry = format!("disturbance.{number}");
        Some(Replaced {
            by: format!("{entry}.{by}"),
            why: format!("{why} `{entry}.{by}` from the beginning of the run"),
            help: format!("vary `{entry}.{what}`, or another key; a list in a scene replaces the list of its base"),
        })
    }
}
