//! Over-temperature and mean power: the drive is derated before a fault ends it.
//!
//! The hotter of two temperatures counts: the sensor at the driver, and the [stack](stack). A
//! sensor at the stack (`thermometer.at_stack`) replaces both.
//!
//! From [`DERATE_K`] below `limits.temperature_c` the amplitude falls linearly to a tenth at the
//! limit; above the limit it is fault 44. An integrator on a second factor holds the mean power
//! over `POWER_S` at `limits.power_w`: `f(n + 1) = f(n) + g (1 - P / P0)`. The smaller factor acts.

mod balance;
mod stack;

pub(crate) use stack::Thermometers;

use crate::guard::heat::stack::Stack;
use crate::seam::compare::smaller;
use crate::seam::config::Config;
use crate::seam::fault::Fault;

/// Temperature difference below the limit at which derating begins, K.
pub const DERATE_K: f32 = 20.0;
/// Smallest factor of the amplitude: enough to track the resonance.
const MIN_FACTOR: f32 = 0.1;
/// Time constant of the mean power, s.
const POWER_S: f32 = 1e-3;
/// Ceiling of the mean power, W: above any limit.
const MAX_MEAN_W: f32 = 1e6;
/// Time constant of the power integrator, s: slow against the ring-up of any stack.
const INTEGRATOR_S: f32 = 32e-3;

/// Derating and limit of temperature and mean power.
#[derive(Clone, Debug)]
pub(crate) struct Heat {
    most_c: f32,
    /// `true` if the board's sensor is at the stack.
    at_stack: bool,
    stack: Stack,
    by_heat: f32,
    most_w: f32,
    gain: f32,
    mean_part: f32,
    mean_w: f32,
    by_power: f32,
    /// Factor of the amplitude: the smaller of `by_heat` and `by_power`.
    factor: f32,
}

impl Heat {
    /// Builds the watch from the configured limits and thermal values.
    pub(crate) fn build(config: &Config, block_s: f32) -> Self {
        Heat {
            most_c: config.limits.temperature_c,
            at_stack: config.thermometer.at_stack,
            stack: Stack::build(config, block_s),
            by_heat: 1.0,
            most_w: config.limits.power_w.unwrap_or(f32::INFINITY),
            gain: block_s / INTEGRATOR_S,
            mean_part: block_s / POWER_S,
            mean_w: 0.0,
            by_power: 1.0,
            factor: 1.0,
        }
    }

    /// Updates the temperature of the stack from the tracker's estimates.
    pub(super) fn update_temperature(&mut self, now: &Thermometers) {
        self.stack.read(now);
    }

    /// Returns `true` if the stack was read as its own thermometer.
    #[inline]
    pub(super) fn has_reading(&self) -> bool {
        self.stack.has_reading()
    }

    /// Returns `true` if the energy that the stack takes bounds its temperature.
    pub(super) fn has_balance(&self) -> bool {
        self.stack.has_balance()
    }

    /// Checks the temperatures of one block: that of the board, °C, and that of the stack, which
    /// has taken the mean power `taken_w`, W.
    pub(super) fn inspect_temperature(&mut self, board_c: Option<f32>, taken_w: f32) -> Option<Fault> {
        if self.stack.is_used() {
            self.stack.add(board_c, taken_w);
        }
        let hottest = match board_c {
            Some(board_c) if self.at_stack || !self.stack.is_known() => board_c,
            None if !self.stack.is_known() => return None,
            _ => self.stack.hotter(board_c),
        };
        let margin_k = self.most_c - hottest;
        self.by_heat = (MIN_FACTOR + (1.0 - MIN_FACTOR) / DERATE_K * margin_k).clamp(MIN_FACTOR, 1.0);
        self.factor = smaller(self.by_heat, self.by_power);
        (margin_k.is_nan() || margin_k < 0.0).then_some(Fault::OverTemperature)
    }

    /// Limits the mean power by one block under drive, W.
    pub(super) fn limit_power(&mut self, power_w: f32) {
        if self.most_w < f32::INFINITY {
            // A power that is not a number counts as above every limit.
            self.mean_w = smaller(self.mean_w + self.mean_part * (power_w - self.mean_w), MAX_MEAN_W);
            let factor = self.by_power + self.gain * (1.0 - self.mean_w / self.most_w);
            self.by_power = factor.clamp(MIN_FACTOR, 1.0);
            self.factor = smaller(self.by_heat, self.by_power);
        }
    }

    /// Returns the factor of the amplitude set point, 0.1 to 1.
    pub(super) fn factor(&self) -> f32 {
        self.factor
    }
}

#[cfg(test)]
mod tests;
