//! Actuators that lower the friction at the D-ring, and their laws of sliding speed.
//!
//! Each law is used in its inverse form: it gives the speed at which the webbing must slide for the
//! friction to have the ratio `r` to the friction without an actuator. `Fc` is the friction force
//! without an actuator (see [`capstan`](super::capstan)). No actuator brings `r` below
//! `mu_low / mu_high`.
//!
//! | actuator | law | source |
//! |---|---|---|
//! | ideal | `r = 1 - (1 - mu_low / mu_high) a`, at any speed | a perfect switch |
//! | tangential | `r = (2 / pi) asin(Vs / a Vt)`, 1 for `Vs >= a Vt` | Coulomb under a sine of tip velocity `Vt`, thesis 4.3 |
//! | tangential, Dahl | `r = (pi / 2) xi / (xi asin xi + sqrt(1 - xi^2))`, `xi = Vs / a Vt` | the limit of Dahl's law for a soft contact, docs/dev/plant.md |
//! | power | `r = (2 / pi) atan(2 Fc Vs / (pi a P))` | the tangential law with the tip velocity that `P` watts maintain |
//! | stack | tangential, with the tip velocity of the simulated stack | the 40 kHz stack; its tip is assumed to move freely |
//! | ring | at each place of the wrap by the local direction of the ring's vibration, with this tip velocity | `contact::wrap` |
//! | normal | `1 - r = a 0.587 (1 + 25 / 38.3) / (1 + Vs / 38.3 mm/s) (N / 270 N)^-0.0584` | fitted to measurements at 20 to 87 mm/s, **extrapolated** |
//!
//! `a`, from 0 to 1, is the present amplitude relative to the full one.
//!
//! The power of a tangential sine against Coulomb friction is `P = (2 / pi) Fc Vt sqrt(1 - xi^2)`.
//! With `xi = sin(pi r / 2)` that becomes the law by power. The normal law was fitted to the belt
//! experiments at 70 % amplitude. It omits the half second over which the reduction rose in the
//! experiments, so it predicts a faster actuator than measured.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, TAU};
use std::sync::Arc;

use super::capstan::Capstan;
use super::state::Way;
use contact::wrap::normal::Normal;
use contact::wrap::table::{Table, Tensioned};
use contact::wrap::{Pull, Ring};
use scene::{self, ActuatorKind};

/// Speed at which normal vibration has lost half its effect, m/s.
const NORMAL_HALF_M_PER_S: f64 = 38.3e-3;
/// Reduction of the friction by normal vibration at the reference speed and force, relative.
const NORMAL_EFFECT: f64 = 0.587;
/// Reference speed of the normal law, m/s.
const NORMAL_AT_M_PER_S: f64 = 25e-3;
/// Reference force of the normal law, N.
const NORMAL_AT_N: f64 = 270.0;
/// Exponent of the normal force in the normal law.
const NORMAL_EXPONENT: f64 = -0.0584;
/// Lower limit of the amplitude in the laws, so that no law becomes too steep to integrate.
const MIN_AMPLITUDE: f64 = 0.01;
/// Least distance of a ratio from one, at which some speeds are infinite.
const RATIO_MARGIN: f64 = 1e-6;

/// The actuator that lowers the friction.
#[derive(Clone, Debug, PartialEq)]
pub enum Actuator {
    /// No actuator.
    None,
    /// A perfect switch of the friction.
    Ideal,
    /// A tip that vibrates along the webbing with this peak velocity, m/s, by Coulomb's law.
    Tangential(f64),
    /// A tip that vibrates along the webbing with this peak velocity, m/s, by the limit of Dahl's
    /// law.
    TangentialDahl(f64),
    /// This power into the contact, W.
    Power(f64),
    /// The simulated stack, along the webbing: the caller gives its tip velocity while it runs.
    Stack,
    /// A vibration across the webbing.
    Normal,
    /// The whole ring vibrates in one direction with this peak velocity, m/s, by the law along the
    /// wrap.
    Ring(f64, Arc<Table>),
}

/// Range of the friction ratio that an actuator allows at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effect {
    /// The smallest ratio of friction, at rest.
    pub floor: f64,
    /// The largest ratio, at any speed.
    pub full: f64,
}

impl Actuator {
    /// Creates the actuator of a scene's D-ring.
    pub fn from_dring(dring: &scene::Dring) -> Self {
        match dring.actuator {
            ActuatorKind::Ideal => Actuator::Ideal,
            ActuatorKind::Tangential => Actuator::Tangential(dring.tip_m_per_s),
            ActuatorKind::TangentialDahl => Actuator::TangentialDahl(dring.tip_m_per_s),
            ActuatorKind::Power => Actuator::Power(dring.power_w),
            // A validated scene with a ring has a direction.
            ActuatorKind::Ring => Self::along_the_wrap(dring, dring.tip_m_per_s).unwrap_or(Actuator::None),
            ActuatorKind::Stack => Self::along_the_wrap(dring, 0.0).unwrap_or(Actuator::Stack),
            ActuatorKind::Normal => Actuator::Normal,
        }
    }

    /// Returns the ring of a scene that vibrates as a whole in one direction, with this tip
    /// velocity, m/s.
    fn along_the_wrap(dring: &scene::Dring, tip_m_per_s: f64) -> Option<Self> {
        let vibration = dring.ring_vibration()?;
        let floor = dring.mu_low.min(dring.mu_high) / dring.mu_high;
        let ring = Ring::new(dring.wrap_deg, dring.mu_high, floor, (vibration.angle_deg, vibration.axis_deg)).ok()?;
        let normal = vibration.fitted.map(|(hz, radius_m)| Normal { amplitude_m: tip_m_per_s / (TAU * hz), radius_m });
        Some(Actuator::Ring(tip_m_per_s, Arc::new(Table::new(ring, normal))))
    }

    /// Returns the actuator while a stack's tip has this velocity, m/s.
    pub fn with_tip(&self, tip_m_per_s: f64) -> Self {
        match self {
            Actuator::Ring(_, table) => Actuator::Ring(tip_m_per_s, Arc::clone(table)),
            _ => Actuator::Tangential(tip_m_per_s),
        }
    }

    /// Returns the range of friction ratios at an amplitude from 0 to 1.
    pub fn effect(&self, capstan: &Capstan, amplitude: f64) -> Effect {
        match *self {
            Actuator::Ideal => {
                let ratio = 1.0 - (1.0 - capstan.floor()) * amplitude;
                Effect { floor: ratio, full: ratio }
            }
            Actuator::None | Actuator::Stack => Effect { floor: 1.0, full: 1.0 },
            Actuator::Tangential(tip) | Actuator::TangentialDahl(tip) | Actuator::Ring(tip, _) if tip <= 0.0 => {
                Effect { floor: 1.0, full: 1.0 }
            }
            _ if amplitude == 0.0 => Effect { floor: 1.0, full: 1.0 },
            _ => Effect { floor: capstan.floor(), full: 1.0 },
        }
    }

    /// Returns the change of both ends of the range with the amplitude, if the ends coincide; else
    /// 0.
    pub fn slope(&self, capstan: &Capstan) -> f64 {
        if *self == Actuator::Ideal { capstan.floor() - 1.0 } else { 0.0 }
    }

    /// Returns the speed at which webbing slides in the given direction at a friction ratio, m/s.
    /// Infinite if any speed is possible.
    pub fn speed(&self, capstan: &Capstan, amplitude: f64, ratio: f64, (way, high_n, low_n): (Way, f64, f64)) -> f64 {
        let amplitude = amplitude.max(MIN_AMPLITUDE);
        let ratio = ratio.clamp(0.0, 1.0);
        let difference_n = high_n - low_n;
        match *self {
            Actuator::None | Actuator::Ideal | Actuator::Stack => f64::INFINITY,
            Actuator::Tangential(tip) => amplitude * tip * libm::sin(FRAC_PI_2 * ratio),
            Actuator::TangentialDahl(tip) => amplitude * tip * dahl_velocity_ratio(ratio),
            Actuator::Power(watts) => {
                let ratio = ratio.clamp(RATIO_MARGIN, 1.0 - RATIO_MARGIN);
                FRAC_PI_2 * amplitude * watts * ratio / difference_n.max(f64::MIN_POSITIVE) * libm::tan(FRAC_PI_2 * ratio)
            }
            Actuator::Normal => {
                let normal_n = difference_n / (ratio * capstan.mu_high);
                let at_rest = NORMAL_EFFECT * (1.0 + NORMAL_AT_M_PER_S / NORMAL_HALF_M_PER_S);
                let effect = amplitude * at_rest * libm::pow(normal_n / NORMAL_AT_N, NORMAL_EXPONENT);
                (NORMAL_HALF_M_PER_S * (effect / (1.0 - ratio).max(RATIO_MARGIN) - 1.0)).max(0.0)
            }
            Actuator::Ring(tip, ref table) => {
                let pull = if way == Way::Out { Pull::Shoulder } else { Pull::Retractor };
                let needed = Tensioned { ratio: ratio.min(1.0 - RATIO_MARGIN), low_n, pull };
                amplitude * tip * table.velocity_ratio(&needed, tip, amplitude)
            }
        }
    }

    /// Returns the power into the contact, W, at a ratio of friction; `None` if the law does not
    /// define it.
    pub fn power_w(&self, amplitude: f64, ratio: f64, difference_n: f64) -> Option<f64> {
        match *self {
            Actuator::Tangential(tip) => {
                let coulomb_n = difference_n / ratio.max(RATIO_MARGIN);
                Some(FRAC_2_PI * coulomb_n * amplitude * tip * libm::cos(FRAC_PI_2 * ratio.min(1.0)))
            }
            Actuator::Power(watts) => Some(amplitude * watts),
            _ => None,
        }
    }
}

/// Returns the velocity ratio `xi` at which the limit of Dahl's law for a soft contact has this
/// ratio of friction: the inverse of `r = (pi / 2) xi / (xi asin xi + sqrt(1 - xi^2))`, which
/// increases.
fn dahl_velocity_ratio(ratio: f64) -> f64 {
    let law = |xi: f64| FRAC_PI_2 * xi / (xi * libm::asin(xi) + libm::sqrt(1.0 - xi * xi));
    // Newton's method. The law is concave and r <= (pi / 2) xi, so it starts below the solution;
    // every step increases xi and stays below.
    let mut xi = ratio / FRAC_PI_2;
    for _ in 0..30 {
        // r' = (pi / 2) sqrt(1 - xi^2) / (xi asin xi + sqrt(1 - xi^2))^2
        let root = libm::sqrt((1.0 - xi * xi).max(0.0));
        let below = xi * libm::asin(xi) + root;
        let slope = FRAC_PI_2 * root / (below * below);
        let step = if slope > 0.0 { (ratio - law(xi)) / slope } else { 0.0 };
        let next = (xi + step).min(1.0);
        if (next - xi).abs() < 1e-15 {
            break;
        }
        xi = next;
    }
    xi
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const D_RING: Capstan = Capstan { wrap_rad: 2.618, mu_high: 0.3, mu_low: 0.13 };

    fn speed(actuator: Actuator, ratio: f64, difference_n: f64) -> f64 {
        actuator.speed(&D_RING, 1.0, ratio, (Way::Out, difference_n, 0.0))
    }

    #[test]
    fn each_law_is_the_inverse_of_its_formula() {
        for ratio in [0.1, 0.433, 0.7, 0.95] {
            let (tip, watts, difference) = (5.0, 2500.0, 900.0);
            let coulomb = speed(Actuator::Tangential(tip), ratio, difference);
            assert!((2.0 / PI * (coulomb / tip).asin() - ratio).abs() < 1e-12);
            let xi = speed(Actuator::TangentialDahl(tip), ratio, difference) / tip;
            assert!((FRAC_PI_2 * xi / (xi * xi.asin() + (1.0 - xi * xi).sqrt()) - ratio).abs() < 1e-12, "{ratio} {xi}");
            let by_power = speed(Actuator::Power(watts), ratio, difference);
            let coulomb_n = difference / ratio;
            assert!((2.0 / PI * (2.0 * coulomb_n * by_power / (PI * watts)).atan() - ratio).abs() < 1e-12);
            // The tip velocity that this power maintains obeys Coulomb's law at this speed.
            let tip = by_power / (FRAC_PI_2 * ratio).sin();
            let power = Actuator::Tangential(tip).power_w(1.0, ratio, difference);
            assert!(power.is_some_and(|power| (power / watts - 1.0).abs() < 1e-12));
        }
    }

    /// The belt experiment: 58.0 % at 25 mm/s and 270 N after two seconds, tending to 58.7 %.
    #[test]
    fn normal_vibration_is_that_of_the_belt_experiment() {
        let (ratio, normal_n) = (1.0 - 0.587, 270.0);
        let found = speed(Actuator::Normal, ratio, ratio * 0.3 * normal_n);
        assert!((found - 25e-3).abs() < 1e-12, "{found}");
    }

    #[test]
    fn limits_of_the_laws() {
        assert_eq!(speed(Actuator::Ideal, 0.5, 1.0), f64::INFINITY);
        assert_eq!(speed(Actuator::Tangential(5.0), 1.0, 1.0), 5.0);
        assert!((speed(Actuator::TangentialDahl(5.0), 1.0, 1.0) - 5.0).abs() < 1e-6);
        assert_eq!(speed(Actuator::TangentialDahl(5.0), 0.0, 1.0), 0.0);
        assert!(speed(Actuator::Power(2500.0), 1.0, 1.0) > 1e9, "any speed");
        let none = Effect { floor: 1.0, full: 1.0 };
        assert_eq!(Actuator::Stack.with_tip(0.0).effect(&D_RING, 1.0), none);
        assert_eq!(Actuator::Power(1.0).effect(&D_RING, 0.0), none);
        let half = Actuator::Ideal.effect(&D_RING, 0.5);
        assert!((half.floor * 0.3 - 0.215).abs() < 1e-15 && half.floor == half.full);
    }
}
