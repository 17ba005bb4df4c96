//! The stack as one body that its losses heat.
//!
//! ```text
//! C dT/dt = P - (T - Ts) / R,    over a block with constant P:  T <- T1 + (T - T1) exp(-h / (R C)),   T1 = Ts + R P
//! ```
//!
//! `T` is the temperature over ambient and `Ts` that of the surroundings, K, `P` the loss of the block, W. The loss grows with temperature, at a
//! constant motional current by the part `s = d ln Rm / dT`. With `g = R s Pm`, `Pm` the motional loss, it comes to
//!
//! ```text
//! T = (Ts + R (P - s Pm T0)) / (1 - g),   where T0 is the temperature at which P and Pm are measured
//! ```
//!
//! as long as `g < 1`. From one on a kelvin brings more loss than leaves with it, and nothing is steady: thermal runaway. A drive of constant
//! voltage has none at resonance, where more resistance takes less power; a controller that holds the tip velocity does.
//!
//! At its Curie point a ceramic has lost its polarisation. From about half of it on (in degrees Celsius; a maker's rule of thumb, `docs/plant.md`)
//! it does so slowly: that is said, and not simulated.

use crate::truth::HeatTruth;
use scene::Thermal;

/// The temperature of a stack on its way.
#[derive(Clone, Debug)]
pub struct Body {
    thermal: Thermal,
    /// What remains of a difference over a block.
    remains: f64,
    temperature_k: f64,
    depoled: bool,
    truth: HeatTruth,
}

/// What a block has lost in a stack.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// In the resistances of the motional branches, W.
    pub motional_w: f64,
    /// In the conductance beside the clamped capacitance, W.
    pub dielectric_w: f64,
    /// By which part the motional loss grows with a kelvin at the same current, 1/K.
    pub per_k: f64,
}

impl Body {
    /// A body that begins at the temperature of its surroundings, K over ambient, in blocks of so many seconds.
    pub fn new(thermal: Thermal, surroundings_k: f64, block_s: f64) -> Self {
        let remains = (-block_s / thermal.time_constant_s()).exp();
        let truth = HeatTruth { temperature_k: surroundings_k, lasting_k: surroundings_k, ..HeatTruth::default() };
        Body { thermal, remains, temperature_k: surroundings_k, depoled: false, truth }
    }

    /// Temperature over ambient, K.
    pub fn temperature_k(&self) -> f64 {
        self.temperature_k
    }

    /// Whether it has come to its Curie point since this was last asked, for the first time.
    pub fn loses_its_polarisation(&mut self) -> bool {
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

    /// How it heated itself in the last block.
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

    /// Blocks of any length come to `T = R P (1 - exp(-t / (R C)))`, and back to the surroundings.
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

    /// A part of the motional loss goes elsewhere; of the dielectric one, none does.
    #[test]
    fn what_is_lost_elsewhere_does_not_heat() {
        let mut body = Body::new(Thermal { heating_fraction: 0.25, ..THERMAL }, 0.0, 1.0);
        body.heat(&Losses { motional_w: 2.0, dielectric_w: 0.1, per_k: 0.01 }, 0.0);
        assert!((body.truth().heating_w - 0.6).abs() < 1e-12 && (body.truth().gain - 0.1).abs() < 1e-12);
    }

    /// At constant current, `P = P0 (1 + c T) + Pd`, it comes to `R (P0 + Pd) / (1 - R P0 c)`, with the time constant `R C / (1 - g)`; what is said beforehand
    /// agrees from the beginning on. With a gain above one it leaves as `exp((g - 1) t / (R C))`, and no end is said.
    #[test]
    fn loss_that_grows_with_temperature_has_an_end_or_none() {
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
            // The loss stands still within a block: the error is of its first order.
            assert!((body.temperature_k() / expected - 1.0).abs() < 3e-4, "{gain}: {} {expected}", body.temperature_k());
        }
    }

    #[test]
    fn polarisation_is_lost_once_at_the_curie_point() {
        let mut body = Body::new(THERMAL, 299.0, 1.0);
        assert!(!body.loses_its_polarisation());
        body.heat(&Losses::default(), 301.0);
        body.heat(&Losses::default(), 301.0);
        assert!(body.temperature_k() > 300.0 && body.loses_its_polarisation() && !body.loses_its_polarisation());
        body.heat(&Losses::default(), 0.0);
        assert!(body.truth().depoled);
    }
}
