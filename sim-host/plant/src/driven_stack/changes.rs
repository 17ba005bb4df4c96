//! Changes of a stack and of its contact by a scene's disturbances.

use super::DrivenStack;
use crate::sliding::Sliding;
use scene::DisturbedKey;

impl DrivenStack {
    /// Applies the scene's disturbances for the block that begins now.
    pub(super) fn disturb(&mut self) {
        let mut changes = std::mem::take(&mut self.changes);
        for change in &mut changes {
            if let Some(value) = change.next(self.time_s, self.value(change.key())) {
                self.set(change.key(), value);
            }
        }
        changes.retain(|change| !change.is_over());
        self.changes = changes;
        self.elements.begin((self.time_s / self.block_s).round() as u64, &mut self.stack);
        self.energy.disturbed_j = self.elements.disturbed_j;
    }

    fn value(&self, key: DisturbedKey) -> f64 {
        if let Some(webbing) = &self.webbing {
            match key {
                DisturbedKey::BeltLoad => return webbing.load_n(),
                DisturbedKey::BeltSpeed => return webbing.belt.nominal_m_per_s(),
                _ => {}
            }
        }
        match (key, self.sliding.as_ref().and_then(Sliding::slider)) {
            (DisturbedKey::Load, Some(sliding)) => sliding.load_n(),
            (DisturbedKey::Speed, Some(sliding)) => sliding.belt.nominal_m_per_s(),
            // Keys of a motor and of contact studies do not apply here.
            _ => self.elements.value(key, &self.stack).unwrap_or(0.0),
        }
    }

    /// Sets a value from now on.
    pub fn set(&mut self, key: DisturbedKey, value: f64) {
        if let Some(webbing) = &mut self.webbing {
            match key {
                DisturbedKey::BeltLoad => return self.elements.damp(webbing.set_load(value), &self.stack),
                DisturbedKey::BeltSpeed => return webbing.belt.set_nominal(value),
                _ => {}
            }
        }
        match (key, self.sliding.as_mut().and_then(Sliding::slider_mut)) {
            (DisturbedKey::Load, Some(sliding)) => sliding.set_load(value),
            (DisturbedKey::Speed, Some(sliding)) => sliding.belt.set_nominal(value),
            _ => self.elements.set(key, value, &self.stack),
        }
    }
}
