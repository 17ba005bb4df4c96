//! The stack as one body heated by its losses.
//!
//! ```text
//! C dT/dt = P - (T - Ts) / R,    over a block with constant P:  T <- T1 + (T - T1) exp(-h / (R C)),   T1 = Ts + R P
//! ```
//!
//! `T` is the temperature over ambient and `Ts` that of the surroundings, K, `P` the loss of the
//! block, W. The loss grows with temperature: at constant motional current by `s = d ln Rm / dT`.
//! With `g = R s Pm`, `Pm` the motional loss, the temperature tends to
//!
//! ```text
//! T = (Ts + R (P - s Pm T0)) / (1 - g),   T0: temperature at which P and Pm are measured
//! ```
//!
//! as long as `g < 1`. From `g = 1` on, each kelvin adds more loss than the heat that it removes,
//! and there is no steady state: thermal runaway. A drive of constant voltage at resonance is
//! stable, as more resistance draws less power. A controller that holds the tip velocity can run
//! away.
//!
//! At its Curie point a ceramic has lost its polarisation. Above about half of it (in degrees
//! Celsius; a manufacturer's rule of thumb, `docs/dev/plant.md`) the loss is slow: it is reported
//! but not simulated.

use crate::truth::HeatTruth;
use scene::Thermal;

/// Temperature of a stack over time.
#[derive(Clone, Debug)]
pub struct Body {
    thermal: Thermal,
    /// Fraction of a temperature difference that remains after a block.
    remains: f64,
    temperature_k: f64,
    depoled: bool,
    truth: HeatTruth,
}

/// Losses of a stack in a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// Losses in the resistances of the motional branches, W.
    pub motional_w: f64,
    /// Loss in the conductance in parallel with the clamped capacitance, W.
    pub dielectric_w: f64,
    /// Relative increase of the motional loss per kelvin at the same current, 1/K.
    pub per_k: f64,
}

impl Body {
    /// Creates a body at the temperature of its surroundings, K over ambient, for blocks of
    /// `block_s` seconds.
    pub fn new(thermal: Thermal, surroundings_k: f64, block_s: f64) -> Self {
        let remains = (-block_s / thermal.time_constant_s()).exp();
        let truth = HeatTruth { temperature_k: surroundings_k, lasting_k: surroundings_k, ..HeatTruth::default() };
        Body { thermal, remains, temperature_k: surroundings_k, depoled: false, truth }
    }

    /// Returns the temperature over ambient, K.
    pub fn temperature_k(&self) -> f64 {
        self.temperature_k
    }

    /// Returns `true` once, on the first call after the body has reached its Curie point.
    pub fn take_depolarisation(&mut self) -> bool {
        let hot = self.thermal.ambient_c + self.temperature_k >= self.thermal.curie_c;
        hot && !std::mem::replace(&mut self.depoled, true)
    }

    /// Ends a block in surroundings of this temperature, K over ambient.
    pub fn heat(&mut self, losses: &Losses, surroundings_k: f64) {
        let Thermal { resistance_k_per_w, heating_fraction, .. } = self.thermal;
        let motional_w = heating_fraction * losses.motional_w;
        let heating_w = motional_w + losses.dielectric_w;
        let gain = resistance_k_per_w * losses.per_k * motional_w;
        let reached_k = surroundings_k + resistance_k_per_w * (heating_w - losses.per_k * motional_w * self.temperature_k);
        let lasting_k = if gain < 1.0 { reached_k / (1.0 - gain) } else { f64::NAN };
        let end_k = surroundings_k + resistance_k_per_w * heating_w;
        self.temperature_k = end_k + (self.temperature_k - end_k) * self.remains;
        self.truth = HeatTruth { temperature_k: self.temperature_k, heating_w, gain, lasting_k, depoled: self.depoled };
    }

    /// Returns the thermal state after the last block.
    pub fn truth(&self) -> HeatTruth {
        self.truth
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const THERMAL: Thermal = Thermal {
        heat_capacity_j_per_k: 0.05,
        resistance_k_per_w: 20.0,
        heating_fraction: 1.0,
        ambient_c: 25.0,
        curie_c: 325.0,
        depoling_c: None,
    };

    /// Blocks of any length give `T = R P (1 - exp(-t / (R C)))`, and return to the temperature of
    /// the surroundings.
    #[test]
    fn a_constant_loss_heats_by_the_closed_form() {
        let losses = Losses { motional_w: 1.5, dielectric_w: 0.5, per_k: 0.0 };
        for block_s in [32e-6, 1e-2, 0.5] {
            let mut body = Body::new(THERMAL, 0.0, block_s);
            let blocks = (1.5 / block_s) as u32;
            (0..blocks).for_each(|_| body.heat(&losses, 0.0));
            let expected = -40.0 * (-f64::from(blocks) * block_s).exp_m1();
            assert!((body.temperature_k() / expected - 1.0).abs() < 1e-10, "{block_s}: {}", body.temperature_k());
            assert!((body.truth().lasting_k - 40.0).abs() < 1e-12);
            (0..40 * blocks).for_each(|_| body.heat(&Losses::default(), 7.0));
            assert!((body.temperature_k() - 7.0).abs() < 1e-10, "{}", body.temperature_k());
        }
    }

    /// Part of the motional loss does not heat the body; all of the dielectric loss does.
    #[test]
    fn only_the_heating_fraction_heats() {
        let mut body = Body::new(Thermal { heating_fraction: 0.25, ..THERMAL }, 0.0, 1.0);
        body.heat(&Losses { motional_w: 2.0, dielectric_w: 0.1, per_k: 0.01 }, 0.0);
        assert!((body.truth().heating_w - 0.6).abs() < 1e-12 && (body.truth().gain - 0.1).abs() < 1e-12);
    }

    /// At constant current, `P = P0 (1 + c T) + Pd`, the temperature tends to
    /// `R (P0 + Pd) / (1 - R P0 c)`, with the time constant `R C / (1 - g)`; the predicted value
    /// agrees from the beginning. With a gain above one the temperature diverges as
    /// `exp((g - 1) t / (R C))`, and no end is predicted.
    #[test]
    fn growing_loss_settles_or_runs_away() {
        const DIELECTRIC_W: f64 = 0.2;
        for (cold_w, per_k) in [(1.0, 0.01), (1.0, 0.04), (2.0, 0.024), (2.0, 0.03), (1.0, -0.02)] {
            let block_s = 1e-4;
            let mut body = Body::new(THERMAL, 3.0, block_s);
            let gain: f64 = 20.0 * cold_w * per_k;
            let end_k = (3.0 + 20.0 * (cold_w + DIELECTRIC_W)) / (1.0 - gain);
            let blocks = 20_000;
            for _ in 0..blocks {
                let factor = 1.0 + per_k * body.temperature_k();
                body.heat(&Losses { motional_w: cold_w * factor, dielectric_w: DIELECTRIC_W, per_k: per_k / factor }, 3.0);
                assert!((body.truth().gain - gain).abs() < 1e-12);
                match gain < 1.0 {
                    true => assert!((body.truth().lasting_k / end_k - 1.0).abs() < 1e-9, "{}", body.truth().lasting_k),
                    false => assert!(body.truth().lasting_k.is_nan()),
                }
            }
            let seconds = f64::from(blocks) * block_s;
            let expected = end_k + (3.0 - end_k) * ((gain - 1.0) * seconds).exp();
            // The loss is constant within a block: the error is of first order in the block length.
            assert!((body.temperature_k() / expected - 1.0).abs() < 3e-4, "{gain}: {} {expected}", body.temperature_k());
        }
    }

    #[test]
    fn polarisation_is_lost_once_at_the_curie_point() {
        let mut body = Body::new(THERMAL, 299.0, 1.0);
        assert!(!body.take_depolarisation());
        body.heat(&Losses::default(), 301.0);
        body.heat(&Losses::default(), 301.0);
        assert!(body.temperature_k() > 300.0 && body.take_depolarisation() && !body.take_depolarisation());
        body.heat(&Losses::default(), 0.0);
        assert!(body.truth().depoled);
    }
}
