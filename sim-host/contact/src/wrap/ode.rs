//! The capstan equation along the wrap, with any normal part: `d ln T / dp = mu r_s(p) r_n(p, T)`.

use super::gauss::Walk;
use super::normal::NormalPart;
use super::{Pull, Ring};

/// Permitted error of the exponent per panel.
const TOLERANCE: f64 = 1e-12;

/// Vibration of a ring under sliding webbing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sliding {
    /// Sliding speed, m/s.
    pub speed_m_per_s: f64,
    /// Peak velocity of the vibration, m/s.
    pub tip_m_per_s: f64,
    /// Frequency of the vibration, Hz.
    pub hz: f64,
    /// Lower tension, N.
    pub low_n: f64,
    /// End that pulls.
    pub pull: Pull,
    /// `true` if the in-surface part of the vibration acts; otherwise the normal part acts alone.
    pub in_surface: bool,
}

impl Ring {
    /// Computes `ln(T_high / T_low)` with a normal part, and its error.
    pub fn tension_exponent(&self, normal: &NormalPart, sliding: &Sliding) -> (f64, f64) {
        let ring = if sliding.pull == Pull::Shoulder { *self } else { Ring { angle_rad: -self.angle_rad, ..*self } };
        let velocity_ratio = if sliding.in_surface { sliding.speed_m_per_s / sliding.tip_m_per_s } else { f64::INFINITY };
        let kinks = ring.kinks(velocity_ratio, &normal.kinks());
        let place = |place: f64| {
            let parts = ring.parts(place);
            (ring.of_tangential(parts.tangential, velocity_ratio), parts.normal)
        };
        let rate = |&(ratio, part): &(f64, f64), state: [f64; 2]| {
            let tension_n = sliding.low_n * state[0].exp();
            [self.mu * ratio * normal.ratio(part, tension_n, sliding.speed_m_per_s, self.mu, sliding.hz), 0.0]
        };
        let walk = Walk { place: &place, rate: &rate, feels_state: true, tolerance: TOLERANCE };
        let ([exponent, _], error) = walk.along(&kinks, [0.0, 0.0]);
        (exponent, error)
    }

    /// Computes the same exponent by the classical Runge-Kutta method in equal steps of the tension
    /// itself. This reference does not use panels between kinks, so a kink within a step lowers its
    /// order.
    pub fn stepped_exponent(&self, steps: u32, normal: &NormalPart, sliding: &Sliding) -> f64 {
        let sign = if sliding.pull == Pull::Shoulder { 1.0 } else { -1.0 };
        let step = self.wrap_rad / f64::from(steps);
        let rate = |from_low: f64, tension: f64| {
            let place = sign * (from_low - 0.5 * self.wrap_rad);
            let normal = normal.ratio(self.parts(place).normal, tension, sliding.speed_m_per_s, self.mu, sliding.hz);
            self.mu * self.in_surface(place, sliding.speed_m_per_s / sliding.tip_m_per_s) * normal * tension
        };
        let mut tension = sliding.low_n;
        for index in 0..steps {
            let at = step * f64::from(index);
            let one = rate(at, tension);
            let two = rate(at + 0.5 * step, tension + 0.5 * step * one);
            let three = rate(at + 0.5 * step, tension + 0.5 * step * two);
            let four = rate(at + step, tension + step * three);
            tension += step / 6.0 * (one + 2.0 * (two + three) + four);
        }
        (tension / sliding.low_n).ln()
    }
}
