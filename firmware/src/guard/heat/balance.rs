//! Upper bound of the stack's temperature from the energy that it has taken: no resonance is
//! needed, so that no load can hide the heat.
//!
//! ```text
//! C dT/dt = P - (T - Ta) / R,   over a step of h seconds:   T <- T1 + (T - T1) exp(-h / (R C)),   T1 = Ta + R P
//! ```
//!
//! `P` is the mean of voltage times current over all samples, W. It includes harmonics, the edges
//! of bursts and the mechanical load, so that it is at least the heat. `R`, K/W, and `C`, J/K, are
//! known to a relative tolerance. The largest `R` gives the highest temperature. The smallest `C`
//! gives the highest while the stack heats, the largest while it cools. Both are computed, and the
//! hotter one counts; after a short pulse another `C` within 30 % can be hotter by 4 % of its rise.

use crate::seam::config::Config;

/// Assumed time constant of a stack whose thermal resistance is unknown, s: that of a small one.
const UNKNOWN_TIME_CONSTANT_S: f32 = 0.1;
/// Steps in the shortest time constant.
const STEPS_IN_TIME_CONSTANT: f32 = 512.0;
/// Step of a stack whose thermal resistance is unknown, blocks.
const UNKNOWN_STEP_BLOCKS: f32 = 32.0;
/// Longest step, blocks: the sum of the powers keeps its precision.
const MAX_STEP_BLOCKS: f32 = 65_536.0;
/// Assumed fastest heating of a stack whose heat capacity is unknown, K/s.
const UNKNOWN_HEATING_K_PER_S: f32 = 200.0;

/// Energy balance of the stack.
#[derive(Clone, Debug)]
pub(super) struct Balance {
    /// Largest thermal resistance, K/W, and smallest heat capacity, J/K; `None` if unknown.
    body: Option<(f32, f32)>,
    /// Fractions of a temperature difference that remain after a step, with the smallest and the
    /// largest heat capacity.
    remain: [f32; 2],
    /// The same with the smallest resistance and heat capacity: the fastest cooling.
    remain_at_least: f32,
    step_s: f32,
    step_blocks: u32,
    blocks: u32,
    /// Sum of the powers of the blocks of this step, W.
    sum_w: f32,
    /// Upper bounds of the temperature, °C.
    bounds_c: [f32; 2],
    /// Part of the bounds that comes from an assumed warm start, K.
    start_k: f32,
}

/// Limits of the change of the temperature in a step.
pub(super) struct Change {
    /// Largest rise by the energy taken, K.
    pub(super) rise_k: f32,
    /// Smallest fraction of the difference from the surroundings that can remain.
    pub(super) remains: f32,
}

impl Balance {
    /// Builds the balance of a stack that is as hot as `thermometer.start_c` allows.
    pub(super) fn build(config: &Config, block_s: f32) -> Self {
        let thermometer = &config.thermometer;
        let (least, most) = (1.0 - thermometer.tolerance, 1.0 + thermometer.tolerance);
        let body = thermometer.resistance_k_per_w.zip(thermometer.heat_capacity_j_per_k);
        let time_constant =
            |part: f32| body.map_or(UNKNOWN_TIME_CONSTANT_S, |(resistance, capacity)| part * resistance * capacity);
        let blocks = libm::floorf(time_constant(least * least) / (STEPS_IN_TIME_CONSTANT * block_s)).clamp(1.0, MAX_STEP_BLOCKS);
        let blocks = if body.is_some() { blocks } else { UNKNOWN_STEP_BLOCKS };
        let step_s = blocks * block_s;
        let remains = |part: f32| libm::expf(-step_s / time_constant(part));
        let start_c = thermometer.start_c.unwrap_or(config.limits.temperature_c);
        Balance {
            body: body.map(|(resistance, capacity)| (most * resistance, least * capacity)),
            remain: [remains(most * least), remains(most * most)],
            remain_at_least: remains(least * least),
            step_s,
            step_blocks: blocks as u32,
            blocks: 0,
            sum_w: 0.0,
            bounds_c: [start_c.max(thermometer.ambient_c); 2],
            start_k: (start_c - thermometer.ambient_c).max(0.0),
        }
    }

    /// Returns `true` if the thermal resistance is known: there is a bound.
    pub(super) fn is_known(&self) -> bool {
        self.body.is_some()
    }

    /// Adds a block with this mean power, W. At the end of a step, updates the bound and returns
    /// the limits of the change.
    pub(super) fn add(&mut self, power_w: f32, surroundings_c: f32) -> Option<Change> {
        self.sum_w += power_w;
        self.blocks += 1;
        if self.blocks < self.step_blocks {
            return None;
        }
        let mean_w = core::mem::take(&mut self.sum_w) / self.step_blocks as f32;
        self.blocks = 0;
        self.start_k *= self.remain[1];
        let end_c = surroundings_c + self.body.map_or(0.0, |(resistance, _)| resistance * mean_w);
        for (bound_c, remains) in self.bounds_c.iter_mut().zip(self.remain) {
            *bound_c = end_c + (*bound_c - end_c) * remains;
        }
        let heating_k_per_s = self.body.map_or(UNKNOWN_HEATING_K_PER_S, |(_, capacity)| mean_w.max(0.0) / capacity);
        Some(Change { rise_k: heating_k_per_s * self.step_s, remains: self.remain_at_least })
    }

    /// Returns the upper bound of the temperature, °C; minus infinity if it is unknown.
    pub(super) fn bound_c(&self) -> f32 {
        if self.is_known() { self.bounds_c[0].max(self.bounds_c[1]) } else { f32::NEG_INFINITY }
    }

    /// Returns the part of the bound that comes from an assumed warm start, K.
    pub(super) fn start_k(&self) -> f32 {
        if self.is_known() { self.start_k } else { 0.0 }
    }
}
