//! Over-temperature and mean power: the drive is derated before a fault ends it.
//!
//! The hotter of two temperatures counts: the sensor at the driver, and the stack as its own
//! thermometer. The stack's series resonance changes by `hz_per_k` and its clamped capacitance by
//! the part `c0_per_k` a kelvin; the tracker measures both. The reference is their value at the
//! first lock after power-on, at the temperature of the board then, or at `ambient_c` without a
//! board sensor. A load also shifts the resonance, which makes an error of some kelvin. The
//! capacitance does not depend on the load and is known to 1 %.
//!
//! From [`DERATE_K`] below `limits.temperature_c` the amplitude falls linearly to a tenth at the
//! limit; above the limit it is fault 44. An integrator on a second factor holds the mean power
//! over `POWER_S` at `limits.power_w`: `f(n + 1) = f(n) + g (1 - P / P0)`. The smaller factor acts.

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

/// Estimates of the tracker that depend on the temperature of the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Thermometers {
    /// Series resonance, Hz, as an offset from any fixed frequency.
    pub resonance_hz: f32,
    /// Susceptance of the clamped capacitance at a fixed frequency, in any unit.
    pub(crate) susceptance: f32,
}

/// Derating and limit of temperature and mean power.
#[derive(Clone, Debug)]
pub(crate) struct Heat {
    most_c: f32,
    kelvin_per_hz: f32,
    kelvin_per_part: f32,
    /// Last reading of the board's sensor, °C; before the first, the configured ambient
    /// temperature.
    board_c: f32,
    /// Estimates at the first lock, and the temperature of the stack at that time, °C.
    cold: Option<(Thermometers, f32)>,
    stack_c: f32,
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
    /// Builds the watch from the configured limits and temperature coefficients.
    pub(crate) fn build(config: &Config, block_s: f32) -> Self {
        let (limits, thermometer) = (&config.limits, &config.thermometer);
        let inverse = |per_k: f32| if per_k == 0.0 { 0.0 } else { 1.0 / per_k };
        Heat {
            most_c: limits.temperature_c,
            kelvin_per_hz: inverse(thermometer.hz_per_k),
            kelvin_per_part: inverse(thermometer.c0_per_k),
            board_c: thermometer.ambient_c,
            cold: None,
            stack_c: f32::NEG_INFINITY,
            by_heat: 1.0,
            most_w: limits.power_w.unwrap_or(f32::INFINITY),
            gain: block_s / INTEGRATOR_S,
            mean_part: block_s / POWER_S,
            mean_w: 0.0,
            by_power: 1.0,
            factor: 1.0,
        }
    }

    /// Updates the temperature of the stack from the tracker's estimates.
    pub(super) fn update_temperature(&mut self, now: &Thermometers) {
        if self.kelvin_per_hz == 0.0 && self.kelvin_per_part == 0.0 {
            return;
        }
        let (cold, cold_c) = *self.cold.get_or_insert((*now, self.board_c));
        let by_resonance = (now.resonance_hz - cold.resonance_hz) * self.kelvin_per_hz;
        let by_capacitance = (now.susceptance / cold.susceptance - 1.0) * self.kelvin_per_part;
        self.stack_c = cold_c + by_resonance.max(by_capacitance);
    }

    /// Returns `true` if the temperature of the stack is known.
    pub(super) fn has_stack_temperature(&self) -> bool {
        self.cold.is_some()
    }

    /// Checks one block: the board's temperature, °C, and the electrical power, W.
    pub(super) fn inspect(&mut self, board_c: Option<f32>, driving: bool, power_w: f32) -> Option<Fault> {
        if self.most_w < f32::INFINITY && driving {
            // A power that is not a number counts as above every limit.
            self.mean_w = smaller(self.mean_w + self.mean_part * (power_w - self.mean_w), MAX_MEAN_W);
            let factor = self.by_power + self.gain * (1.0 - self.mean_w / self.most_w);
            self.by_power = factor.clamp(MIN_FACTOR, 1.0);
            self.factor = self.by_heat.min(self.by_power);
        }
        if board_c.is_none() && self.cold.is_none() {
            return None;
        }
        self.board_c = board_c.unwrap_or(self.board_c);
        // Not `max`: a board reading that is not a number must reach the check below.
        let hottest = if self.stack_c > self.board_c { self.stack_c } else { self.board_c };
        let margin_k = self.most_c - hottest;
        self.by_heat = (MIN_FACTOR + (1.0 - MIN_FACTOR) / DERATE_K * margin_k).clamp(MIN_FACTOR, 1.0);
        self.factor = self.by_heat.min(self.by_power);
        (margin_k.is_nan() || margin_k < 0.0).then_some(Fault::OverTemperature)
    }

    /// Returns the factor of the amplitude set point, 0.1 to 1.
    pub(super) fn factor(&self) -> f32 {
        self.factor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heat() -> Heat {
        Heat {
            most_c: 80.0,
            kelvin_per_hz: -0.1,
            kelvin_per_part: 250.0,
            board_c: 25.0,
            cold: None,
            stack_c: f32::NEG_INFINITY,
            by_heat: 1.0,
            most_w: f32::INFINITY,
            gain: 1e-3,
            mean_part: 1.0 / 32.0,
            mean_w: 0.0,
            by_power: 1.0,
            factor: 1.0,
        }
    }

    #[test]
    fn the_drive_falls_to_a_tenth_and_ends_above_the_limit() {
        let mut heat = heat();
        for (celsius, factor, fault) in [(25.0, 1.0, false), (60.0, 1.0, false), (70.0, 0.55, false), (79.99, 0.1, false)] {
            assert_eq!(heat.inspect(Some(celsius), true, 1.0).is_some(), fault);
            assert!((heat.factor() - factor).abs() < 1e-3, "{celsius}: {}", heat.factor());
        }
        assert_eq!(heat.inspect(Some(80.1), true, 1.0), Some(Fault::OverTemperature));
        assert_eq!(heat.inspect(Some(f32::NAN), true, 1.0), Some(Fault::OverTemperature));
    }

    #[test]
    fn the_hotter_of_board_and_stack_counts() {
        let stack = |resonance_hz, susceptance| Thermometers { resonance_hz, susceptance };
        let mut heat = heat();
        heat.inspect(Some(30.0), false, 0.0);
        heat.update_temperature(&stack(-50.0, 0.075));
        assert_eq!(heat.stack_c, 30.0);
        // A resonance 400 Hz lower indicates 40 K, a capacitance 20 % higher 50 K.
        heat.update_temperature(&stack(-450.0, 0.075));
        assert!((heat.stack_c - 70.0).abs() < 1e-3, "{}", heat.stack_c);
        heat.update_temperature(&stack(-450.0, 0.075 * 1.2));
        assert!((heat.stack_c - 80.0).abs() < 1e-2, "{}", heat.stack_c);
        heat.update_temperature(&stack(-560.0, 0.075));
        assert_eq!(heat.inspect(Some(30.0), true, 1.0), Some(Fault::OverTemperature));
    }

    #[test]
    fn the_mean_power_is_held_at_its_limit() {
        let mut heat = Heat { most_w: 2.0, ..heat() };
        // 8 W at full amplitude are reduced to 2 W at half the amplitude.
        for _ in 0..10_000 {
            let factor = heat.factor();
            heat.inspect(None, true, 8.0 * factor * factor);
        }
        assert!((heat.factor() - 0.5).abs() < 1e-3, "{}", heat.factor());
        // The factor recovers when the power falls.
        (0..10_000).for_each(|_| assert_eq!(heat.inspect(None, true, 0.5), None));
        assert_eq!(heat.factor(), 1.0);
    }

    #[test]
    fn a_nan_power_counts_as_over_the_limit() {
        let mut heat = Heat { most_w: 2.0, ..heat() };
        heat.inspect(None, true, f32::NAN);
        heat.inspect(None, true, 1.0);
        assert_eq!(heat.factor(), MIN_FACTOR);
        (0..10_000).for_each(|_| assert_eq!(heat.inspect(None, true, 1.0), None));
        assert_eq!(heat.factor(), 1.0);
        (0..10_000).for_each(|_| assert_eq!(heat.inspect(None, true, 3.0), None));
        assert_eq!(heat.factor(), MIN_FACTOR);
    }

    #[test]
    fn the_power_is_reduced_slowly_and_held_in_a_pause() {
        let mut heat = Heat { most_w: 2.0, ..heat() };
        // At twice the limit the factor falls by 0.001 a block after the mean has settled.
        (0..400).for_each(|_| assert_eq!(heat.inspect(None, true, 4.0), None));
        let derated = heat.factor();
        assert!((0.61..0.66).contains(&derated), "{derated}");
        (0..10_000).for_each(|_| assert_eq!(heat.inspect(None, false, 0.0), None));
        assert_eq!(heat.factor(), derated);
        // The smaller factor acts.
        heat.inspect(Some(79.0), true, 4.0);
        assert!((heat.factor() - 0.145).abs() < 1e-3, "{}", heat.factor());
    }

    #[test]
    fn only_above_the_limit_is_a_fault() {
        let mut heat = heat();
        assert_eq!(heat.inspect(Some(80.0), true, 1.0), None);
        assert_eq!(heat.inspect(Some(80.001), false, 0.0), Some(Fault::OverTemperature));
    }

    #[test]
    fn the_configured_coefficients_set_the_thermometer() {
        let celsius = |hz_per_k: f32, c0_per_k: f32| {
            let mut config = crate::board::parameters::tests::config();
            (config.thermometer.hz_per_k, config.thermometer.c0_per_k, config.thermometer.ambient_c) = (hz_per_k, c0_per_k, 20.0);
            let mut heat = Heat::build(&config, 32e-6);
            heat.update_temperature(&Thermometers { resonance_hz: 100.0, susceptance: 0.08 });
            heat.update_temperature(&Thermometers { resonance_hz: -50.0, susceptance: 0.08 * 1.1 });
            heat.has_stack_temperature().then_some(heat.stack_c)
        };
        assert_eq!(celsius(0.0, 0.0), None);
        // A resonance 150 Hz lower indicates 15 K, a capacitance 10 % higher 25 K.
        assert!(celsius(-10.0, 0.0).is_some_and(|found| (found - 35.0).abs() < 0.01));
        assert!(celsius(0.0, 4e-3).is_some_and(|found| (found - 45.0).abs() < 0.01));
        assert!(celsius(-10.0, 4e-3).is_some_and(|found| (found - 45.0).abs() < 0.01));
    }

    #[test]
    fn the_power_is_averaged_over_1_ms_and_reduced_over_32_ms() {
        let mut config = crate::board::parameters::tests::config();
        config.limits.power_w = Some(2.0);
        let mut heat = Heat::build(&config, 32e-6);
        // Three times the limit for 8 ms: the factor falls by 2 (8 - 1) / 32, 1 ms being the delay
        // of the mean, and a little less while the mean settles.
        (0..250).for_each(|_| assert_eq!(heat.inspect(None, true, 6.0), None));
        assert!((heat.factor() - 0.585).abs() < 0.01, "{}", heat.factor());
    }
}
