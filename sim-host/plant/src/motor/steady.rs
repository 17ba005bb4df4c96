//! Torque and speed of a pure travelling wave in closed form, without steps in time.
//!
//! With the rotor at the height `h` over crests of `A`, the pressure is proportional to
//! `cos p - h / A` over `|p| < pc`, `cos pc = h / A` (the whole turn for `h < -A`), and the surface
//! moves at `V cos p`. A rotor at `v` is slower than the surface inside `|p| < theta`,
//! `cos theta = v / V`, and faster outside:
//!
//! ```text
//! F(v) = mu N (2 G(theta) / G(pc) - 1),   G(p) = sin p - p h / A,   F = mu N for theta >= pc
//! ```
//!
//! At no load `G(theta) = G(pc) / 2`, for any friction and preload: the rotor is slower than the
//! crests because the flanks of the zone are.

use std::f64::consts::PI;

/// Number of bisection steps, down to round-off.
const HALVINGS: usize = 60;

/// A rotor on a pure travelling wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steady {
    /// Height of the rotor relative to that of the crests, at most one; less than minus one if the
    /// wave touches everywhere.
    level: f64,
}

/// Returns the `x` between two ends at which a rising function reaches a value.
fn root(mut low: f64, mut high: f64, target: f64, of: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if of(middle) < target { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

impl Steady {
    /// Solves for crests of `amplitude` m on a layer of `stiffness` N/m under `preload` N: the root
    /// of `sin pc - pc cos pc = pi N / (S A)`.
    pub fn new(amplitude: f64, stiffness: f64, preload: f64) -> Self {
        let pressed = preload / (stiffness * amplitude);
        if pressed >= 1.0 {
            return Steady { level: -pressed };
        }
        Steady { level: libm::cos(root(0.0, PI, PI * pressed, |p| libm::sin(p) - p * libm::cos(p))) }
    }

    /// Creates a rotor on crests that touch over an angle of `zone` rad to either side.
    pub fn from_zone(zone: f64) -> Self {
        Steady { level: libm::cos(zone) }
    }

    /// Returns half the angle over which a crest touches, rad.
    pub fn zone(&self) -> f64 {
        libm::acos(self.level.max(-1.0))
    }

    fn area(&self, p: f64) -> f64 {
        libm::sin(p) - p * self.level
    }

    /// Returns the friction on a rotor at `ratio` = v / V, as a fraction `F / (mu N)`, -1 to 1.
    pub fn pull(&self, ratio: f64) -> f64 {
        let theta = libm::acos(ratio.clamp(-1.0, 1.0)).min(self.zone());
        2.0 * self.area(theta) / self.area(self.zone()) - 1.0
    }

    /// Returns the speed ratio v / V at which the friction is the fraction `pull` of `mu N`, -1 to
    /// 1.
    pub fn speed_ratio(&self, pull: f64) -> f64 {
        libm::cos(root(0.0, self.zone(), pull, |theta| self.pull(libm::cos(theta))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::crest::{Crest, Layer};

    /// Values computed in advance, independently of this code.
    #[test]
    fn no_load_speed_matches_the_table() {
        for (degrees, ratio) in [(15.0f64, 0.9959), (30.0, 0.9836), (45.0, 0.9637), (60.0, 0.9368)] {
            let got = Steady::from_zone(degrees.to_radians()).speed_ratio(0.0);
            assert!((got - ratio).abs() < 5e-5, "{degrees}: {got}");
        }
    }

    #[test]
    fn general_contact_matches_the_closed_form() {
        let layer = Layer { mu: 0.3, stiffness_n_per_m: 5e7 };
        for level in [0.996, 0.87, 0.5, -0.5, -1.0, -3.0] {
            for ratio in [-1.5, -0.5, 0.0, 0.6, 0.95, 0.999, 1.2] {
                let crest = Crest { height_m: 1e-6, rotor_m: 1e-6 * level, along_m_per_s: 0.1, across_m_per_s: 0.0 };
                let general = crest.friction(&layer, 0.1 * ratio);
                let closed = Steady { level }.pull(ratio) * layer.mu * general.normal_n;
                assert!((general.force_n - closed).abs() < 1e-12 * general.normal_n, "{level} {ratio}");
            }
        }
    }

    #[test]
    fn speed_and_pull_are_inverse() {
        for level in [0.97, 0.5, -0.9, -2.0] {
            for part in [-0.9, -0.3, 0.0, 0.5, 0.95] {
                let steady = Steady { level };
                assert!((steady.pull(steady.speed_ratio(part)) - part).abs() < 1e-9, "{level} {part}");
            }
        }
    }

    #[test]
    fn the_zone_follows_from_the_preload() {
        let stiffness = 5.0 * PI / (60f64.to_radians().sin() - PI / 6.0) / 1e-6;
        assert!((Steady::new(1e-6, stiffness, 5.0).zone().to_degrees() - 60.0).abs() < 1e-6);
        // A wave smaller than the approach: the rotor is at -N / S.
        assert_eq!(Steady::new(2e-8, 5e7, 5.0).level, -5.0);
    }
}
