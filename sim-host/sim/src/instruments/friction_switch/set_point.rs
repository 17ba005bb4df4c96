//! Set point of the friction ratio: a function of time and, for a knob with detents, of its
//! position.

use super::metrics::configured;
use crate::record::Row;
use scene::Friction;

/// Set point of a run's friction switch.
pub(super) struct SetPoint<'a> {
    friction: &'a Friction,
    first: f64,
}

impl<'a> SetPoint<'a> {
    /// Creates the set point; `coulomb_n` is the friction without vibration, N.
    pub(super) fn new(friction: &'a Friction, coulomb_n: f64) -> Self {
        SetPoint { friction, first: configured(friction, coulomb_n).unwrap_or(1.0) }
    }

    /// Returns the set point of a block, at the true position of the knob.
    pub(super) fn at(&self, row: &Row) -> f64 {
        let friction = self.friction;
        let step = friction.step_s.iter().zip(&friction.step_ratio).rfind(|(at_s, _)| **at_s <= row.time_s);
        at_place(friction, step.map_or(self.first, |(_, ratio)| *ratio), row)
    }
}

/// Returns the set point of a block; `between` is the ratio between the detents.
pub(super) fn at_place(friction: &Friction, between: f64, row: &Row) -> f64 {
    if friction.detent_pitch_m == 0.0 {
        return between;
    }
    let detents = row.truth.belt_position_m / friction.detent_pitch_m;
    let away = 2.0 * (detents - detents.round()).abs();
    // The slope is zero at a detent and halfway to the next.
    friction.detent_ratio + (between - friction.detent_ratio) * away * away * (3.0 - 2.0 * away)
}
