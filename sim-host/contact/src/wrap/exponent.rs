//! The exponent of the capstan along the wrap, `ln(T_high / T_low)`.
//!
//! Without a normal part it is `mu G`, `G = int r_s dp`, at any tension. The fitted normal part
//! depends on a power of the tension, and the capstan equation is Bernoulli's equation. With
//! `y = (T / T0)^q`, `T0 = W0 R / L`, q the exponent of the load, e the fitted effect at the speed,
//! and f its share at the position:
//!
//! ```text
//! dT/dp = mu r_s (1 - e f (T / T0)^-q) T        dy/dp = q mu r_s (y - e f)
//! ln(T_high / T_low) = mu G + ln(1 - q e mu H / y_low) / q,   H = int r_s f exp(-q mu G(p)) dp
//! ```
//!
//! So two numbers, G and H, give it for all tensions, speeds and amplitudes at one velocity ratio.

use super::super::empirical::EmpiricalLaw;
use super::gauss::Walk;
use super::normal::{Normal, fitted_effect};
use super::{Pull, Ring};

/// Permitted error of G and H per panel, rad.
const TOLERANCE_RAD: f64 = 1e-13;

/// Integrals along the wrap at a velocity ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exponent {
    /// G: integral of the in-surface friction ratio over the angle, rad.
    pub in_surface_rad: f64,
    /// H: integral of the share of the fitted normal effect; zero without one.
    pub fitted_rad: f64,
    /// Estimated error of both, rad.
    pub error_rad: f64,
}

impl Ring {
    /// Computes the integrals along the wrap at a velocity ratio, starting at the end with the
    /// lower tension.
    pub fn exponent(&self, velocity_ratio: f64, normal: Option<&Normal>, pull: Pull) -> Exponent {
        // Seen from the shoulder, the same ring is the mirror image.
        let ring = if pull == Pull::Shoulder { *self } else { Ring { angle_rad: -self.angle_rad, ..*self } };
        let kinks = ring.kinks(velocity_ratio, &normal.map(Normal::saturated).into_iter().collect::<Vec<_>>());
        let decay = EmpiricalLaw::FITTED.load_exponent * self.mu;
        let place = |place: f64| {
            let parts = ring.parts(place);
            (ring.of_tangential(parts.tangential, velocity_ratio), normal.map_or(0.0, |normal| normal.share(parts.normal)))
        };
        let rate = |&(ratio, share): &(f64, f64), state: [f64; 2]| {
            [ratio, if share == 0.0 { 0.0 } else { ratio * share * (-decay * state[0]).exp() }]
        };
        let walk = Walk { place: &place, rate: &rate, feels_state: normal.is_some(), tolerance: TOLERANCE_RAD };
        let ([in_surface_rad, fitted_rad], error_rad) = walk.along(&kinks, [0.0, 0.0]);
        Exponent { in_surface_rad, fitted_rad, error_rad }
    }

    /// Returns the tension at which a face of the horn carries the reference load of the fitted
    /// law, N.
    pub(super) fn reference_n(normal: &Normal) -> f64 {
        EmpiricalLaw::FITTED.load_n / normal.load_n(1.0)
    }

    /// Returns q, and y at the lower tension.
    fn fitted_load(normal: &Normal, low_n: f64) -> (f64, f64) {
        let q = EmpiricalLaw::FITTED.load_exponent;
        (q, (low_n / Self::reference_n(normal)).powf(q))
    }

    /// Returns c and `q mu wrap` of `ln(1 - c e s) / (q mu wrap)`: the reduction of the mean
    /// friction ratio by the fitted normal part with effect e and mean share s, at the lower
    /// tension.
    pub(super) fn fitted_constants(&self, normal: &Normal, low_n: f64) -> (f64, f64) {
        let (q, y) = Self::fitted_load(normal, low_n);
        let per_exponent = q * self.mu * self.wrap_rad;
        (per_exponent / y, per_exponent)
    }

    /// Returns the change of the exponent by the fitted normal part at the lower tension:
    /// `ln(1 - q e mu H / y) / q`.
    pub(super) fn fitted_loss(&self, fitted_rad: f64, effect: f64, normal: &Normal, low_n: f64) -> f64 {
        let (q, y) = Self::fitted_load(normal, low_n);
        (-q * effect * self.mu * fitted_rad / y).ln_1p() / q
    }

    /// Returns the exponent with the fitted normal part, at a sliding speed, m/s, a peak velocity
    /// of the vibration, m/s, and the lower tension, N.
    pub fn fitted_exponent(&self, speed_m_per_s: f64, tip_m_per_s: f64, normal: &Normal, (low_n, pull): (f64, Pull)) -> f64 {
        let found = self.exponent(speed_m_per_s / tip_m_per_s, Some(normal), pull);
        let loss = self.fitted_loss(found.fitted_rad, fitted_effect(speed_m_per_s), normal, low_n);
        self.mu * found.in_surface_rad + loss
    }
}
