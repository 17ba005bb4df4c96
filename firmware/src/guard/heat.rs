//! Too hot, or too much power: the drive is derated before it is ended.
//!
//! The hottest counts: what the sensor at the driver says, and what the stack says of itself. A stack is its own thermometer: a kelvin
//! moves its series resonance by `hz_per_k` and its clamped capacitance by a part `c0_per_k`, both of which the tracker measures. What
//! they were when the stack was first locked counts as the temperature of the board then, or `ambient_c` without such a sensor; that
//! is retained until power-off. A load moves the resonance, too, and makes it a thermometer of some kelvin; the capacitance does not
//! feel the load, and is known to 1 %.
//!
//! From [`DERATE_K`] below `limits.temperature_c` on, the amplitude asked for falls along a straight line to a tenth at the limit, where it
//! is fault 44. The mean power over `POWER_S` is held at `limits.power_w` by an integrator on the same factor:
//! `f(n + 1) = f(n) + g (1 - P / P0)`.

use crate::seam::compare::smaller;
use crate::seam::config::Config;
use crate::seam::fault::Fault;

/// Derating begins so far below the limit, K.
pub const DERATE_K: f32 = 20.0;
/// What is left of the amplitude at the limit: enough to follow the resonance by.
const LEAST: f32 = 0.1;
/// Memory of the mean power, s.
const POWER_S: f32 = 1e-3;
/// More than any limit, W.
const ANY_W: f32 = 1e6;
/// Time constant of the power's integrator at the limit, s: slow against the ring-up of any stack.
const INTEGRATOR_S: f32 = 32e-3;

/// What the tracker knows of the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Thermometers {
    /// Series resonance, Hz, as an offset from anything fixed.
    pub resonance_hz: f32,
    /// Susceptance of the clamped capacitance at a fixed frequency, in any unit.
    pub(crate) susceptance: f32,
}

/// The watch over temperature and power.
#[derive(Clone, Debug)]
pub(crate) struct Heat {
    most_c: f32,
    kelvin_per_hz: f32,
    kelvin_per_part: f32,
    /// Last reading of the board's sensor; before the first, the configured ambient temperature.
    board_c: f32,
    /// The stack when it was first measured, and its temperature then.
    cold: Option<(Thermometers, f32)>,
    stack_c: f32,
    by_heat: f32,
    most_w: f32,
    gain: f32,
    mean_part: f32,
    mean_w: f32,
    by_power: f32,
    /// What is left of the amplitude by both.
    left: f32,
}

impl Heat {
    /// A watch that keeps the configured limits, by the configured coefficients.
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
            left: 1.0,
        }
    }

    /// Takes what the tracker knows of the stack.
    pub(super) fn update_temperature(&mut self, now: &Thermometers) {
        if self.kelvin_per_hz == 0.0 && self.kelvin_per_part == 0.0 {
            return;
        }
        let (cold, cold_c) = *self.cold.get_or_insert((*now, self.board_c));
        let by_resonance = (now.resonance_hz - cold.resonance_hz) * self.kelvin_per_hz;
        let by_capacitance = (now.susceptance / cold.susceptance - 1.0) * self.kelvin_per_part;
        self.stack_c = cold_c + by_resonance.max(by_capacitance);
    }

    /// Whether the temperature of the stack is known.
    pub(super) fn knows_the_stack(&self) -> bool {
        self.cold.is_some()
    }

    /// Takes one block: the board's temperature, and the power in it, W.
    pub(super) fn inspect(&mut self, board_c: Option<f32>, driving: bool, power_w: f32) -> Option<Fault> {
        if self.most_w < f32::INFINITY && driving {
            // What is no number is over any limit.
            self.mean_w = smaller(self.mean_w + self.mean_part * (power_w - self.mean_w), ANY_W);
            let factor = self.by_power + self.gain * (1.0 - self.mean_w / self.most_w);
            self.by_power = factor.clamp(LEAST, 1.0);
            self.left = self.by_heat.min(self.by_power);
        }
        if board_c.is_none() && self.cold.is_none() {
            return None;
        }
        self.board_c = board_c.unwrap_or(self.board_c);
        // A reading that is not a number is no proof of being cool.
        let hottest = if self.stack_c > self.board_c { self.stack_c } else { self.board_c };
        let left_k = self.most_c - hottest;
        self.by_heat = (LEAST + (1.0 - LEAST) / DERATE_K * left_k).clamp(LEAST, 1.0);
        self.left = self.by_heat.min(self.by_power);
        (left_k.is_nan() || left_k < 0.0).then_some(Fault::OverTemperature)
    }

    /// What is left of the amplitude asked for, a tenth to one.
    pub(super) fn factor(&self) -> f32 {
        self.left
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
            left: 1.0,
        }
    }

    #[test]
    fn the_drive_falls_to_a_tenth_and_ends_at_the_limit() {
        let mut heat = heat();
        for (celsius, factor, fault) in [(25.0, 1.0, false), (60.0, 1.0, false), (70.0, 0.55, false), (79.99, 0.1, false)] {
            assert_eq!(heat.inspect(Some(celsius), true, 1.0).is_some(), fault);
            assert!((heat.factor() - factor).abs() < 1e-3, "{celsius}: {}", heat.factor());
        }
        assert_eq!(heat.inspect(Some(80.1), true, 1.0), Some(Fault::OverTemperature));
        assert_eq!(heat.inspect(Some(f32::NAN), true, 1.0), Some(Fault::OverTemperature));
    }

    #[test]
    fn the_stack_is_its_own_thermometer_and_the_hottest_counts() {
        let stack = |resonance_hz, susceptance| Thermometers { resonance_hz, susceptance };
        let mut heat = heat();
        heat.inspect(Some(30.0), false, 0.0);
        heat.update_temperature(&stack(-50.0, 0.075));
        assert_eq!(heat.stack_c, 30.0);
        // 400 Hz lower is 40 K by the resonance; 20 % more capacitance is 50 K.
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
        // 8 W at full amplitude: half of it is left.
        for _ in 0..10_000 {
            let factor = heat.factor();
            heat.inspect(None, true, 8.0 * factor * factor);
        }
        assert!((heat.factor() - 0.5).abs() < 1e-3, "{}", heat.factor());
        // And it comes back.
        (0..10_000).for_each(|_| assert_eq!(heat.inspect(None, true, 0.5), None));
        assert_eq!(heat.factor(), 1.0);
    }

    #[test]
    fn a_power_that_is_not_a_number_is_over_the_limit_and_the_limit_stays() {
        let mut heat = Heat { most_w: 2.0, ..heat() };
        heat.inspect(None, true, f32::NAN);
        heat.inspect(None, true, 1.0);
        assert_eq!(heat.factor(), LEAST);
        (0..10_000).for_each(|_| assert_eq!(heat.inspect(None, true, 1.0), None));
        assert_eq!(heat.factor(), 1.0);
        (0..10_000).for_each(|_| assert_eq!(heat.inspect(None, true, 3.0), None));
        assert_eq!(heat.factor(), LEAST);
    }

    #[test]
    fn the_power_is_brought_down_slowly_and_stays_down_in_a_pause() {
        let mut heat = Heat { most_w: 2.0, ..heat() };
        // Twice the limit: a thousandth a block, once the mean is there.
        (0..400).for_each(|_| assert_eq!(heat.inspect(None, true, 4.0), None));
        let derated = heat.factor();
        assert!((0.61..0.66).contains(&derated), "{derated}");
        (0..10_000).for_each(|_| assert_eq!(heat.inspect(None, false, 0.0), None));
        assert_eq!(heat.factor(), derated);
        // The lower of both acts.
        heat.inspect(Some(79.0), true, 4.0);
        assert!((heat.factor() - 0.145).abs() < 1e-3, "{}", heat.factor());
    }

    #[test]
    fn at_the_limit_it_is_driven_and_above_it_is_not() {
        let mut heat = heat();
        assert_eq!(heat.inspect(Some(80.0), true, 1.0), None);
        assert_eq!(heat.inspect(Some(80.001), false, 0.0), Some(Fault::OverTemperature));
    }

    #[test]
    fn the_thermometer_is_as_configured() {
        let celsius = |hz_per_k: f32, c0_per_k: f32| {
            let mut config = crate::board::parameters::tests::config();
            (config.thermometer.hz_per_k, config.thermometer.c0_per_k, config.thermometer.ambient_c) = (hz_per_k, c0_per_k, 20.0);
            let mut heat = Heat::build(&config, 32e-6);
            heat.update_temperature(&Thermometers { resonance_hz: 100.0, susceptance: 0.08 });
            heat.update_temperature(&Thermometers { resonance_hz: -50.0, susceptance: 0.08 * 1.1 });
            heat.knows_the_stack().then_some(heat.stack_c)
        };
        assert_eq!(celsius(0.0, 0.0), None);
        // 150 Hz lower are 15 K, a tenth more capacitance is 25 K.
        assert!(celsius(-10.0, 0.0).is_some_and(|found| (found - 35.0).abs() < 0.01));
        assert!(celsius(0.0, 4e-3).is_some_and(|found| (found - 45.0).abs() < 0.01));
        assert!(celsius(-10.0, 4e-3).is_some_and(|found| (found - 45.0).abs() < 0.01));
    }

    #[test]
    fn the_power_is_averaged_over_a_millisecond_and_brought_down_over_thirty() {
        let mut config = crate::board::parameters::tests::config();
        config.limits.power_w = Some(2.0);
        let mut heat = Heat::build(&config, 32e-6);
        // Three times the limit: after 8 ms, less the millisecond, 7 / 32 of twice the amplitude are gone, but for what the mean took to come.
        (0..250).for_each(|_| assert_eq!(heat.inspect(None, true, 6.0), None));
        assert!((heat.factor() - 0.585).abs() < 0.01, "{}", heat.factor());
    }
}
