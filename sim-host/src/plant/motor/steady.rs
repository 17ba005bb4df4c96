//! Torque and speed of a pure travelling wave in closed form: nothing is stepped in time.
//!
//! With pressure `cos p - cos pc` over `|p| < pc` and the surface at `V cos p`, the rotor at `v` slips forwards inside
//! `|p| < theta`, `cos theta = v / V`, and backwards outside:
//!
//! ```text
//! F(v) = mu N (2 G(theta) / G(pc) - 1),   G(p) = sin p - p cos pc,   F = mu N for theta >= pc
//! ```
//!
//! At no load `G(theta) = G(pc) / 2`, whatever friction and preload are: the rotor is slower than the crests because the flanks of
//! the zone are.

use std::f64::consts::PI;

/// Steps of the bisection: the interval halves to round-off.
const HALVINGS: usize = 60;

/// Part `F / (mu N)` of the friction that a rotor at `ratio` = v / V feels, -1 to 1, for a zone of half angle `zone`, rad.
pub fn pull(zone: f64, ratio: f64) -> f64 {
    let area = |p: f64| libm::sin(p) - p * libm::cos(zone);
    let theta = libm::acos(ratio.clamp(-1.0, 1.0)).min(zone);
    2.0 * area(theta) / area(zone) - 1.0
}

/// Speed ratio v / V at which the friction is the part `pull` of `mu N`, -1 to 1.
pub fn speed_ratio(zone: f64, part: f64) -> f64 {
    // The pull rises with theta.
    let (mut low, mut high) = (0.0, zone);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if pull(zone, libm::cos(middle)) < part { low = middle } else { high = middle }
    }
    libm::cos(0.5 * (low + high))
}

/// Half angle of the zone, rad, for crests of `amplitude` m on a layer of `stiffness` N/m under `preload` N: the root of
/// `sin pc - pc cos pc = pi N / (S A)`, or pi where the wave touches everywhere.
pub fn zone(amplitude: f64, stiffness: f64, preload: f64) -> f64 {
    let wanted = PI * preload / (stiffness * amplitude);
    let (mut low, mut high) = (0.0, PI);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if libm::sin(middle) - middle * libm::cos(middle) < wanted { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::motor::crest::{Crest, Layer};

    /// Computed beforehand, independent of this code.
    #[test]
    fn no_load_speed_is_that_of_the_table() {
        for (degrees, ratio) in [(15.0f64, 0.9959), (30.0, 0.9836), (45.0, 0.9637), (60.0, 0.9368)] {
            let got = speed_ratio(degrees.to_radians(), 0.0);
            assert!((got - ratio).abs() < 5e-5, "{degrees}: {got}");
        }
    }

    #[test]
    fn the_general_zone_is_the_same_for_a_pure_wave() {
        let layer = Layer { mu: 0.3, stiffness_n_per_m: 5e7 };
        for degrees in [5.0f64, 30.0, 60.0, 120.0] {
            for ratio in [-1.5, -0.5, 0.0, 0.6, 0.95, 0.999, 1.2] {
                let zone = degrees.to_radians();
                let crest = Crest { height_m: 1e-6, rotor_m: 1e-6 * zone.cos(), along_m_per_s: 0.1, across_m_per_s: 0.0 };
                let general = crest.friction(&layer, 0.1 * ratio);
                let closed = pull(zone, ratio) * layer.mu * general.normal_n;
                assert!((general.force_n - closed).abs() < 1e-12 * general.normal_n, "{degrees} {ratio}");
            }
        }
    }

    #[test]
    fn speed_and_pull_are_inverse() {
        for degrees in [15.0f64, 60.0, 150.0] {
            for part in [-0.9, -0.3, 0.0, 0.5, 0.95] {
                let zone = degrees.to_radians();
                assert!((pull(zone, speed_ratio(zone, part)) - part).abs() < 1e-9, "{degrees} {part}");
            }
        }
    }

    #[test]
    fn the_zone_follows_from_the_preload() {
        assert!((zone(1e-6, 5.0 * PI / (60f64.to_radians().sin() - PI / 6.0) / 1e-6, 5.0).to_degrees() - 60.0).abs() < 1e-6);
        assert_eq!(zone(1e-9, 5e7, 5.0), PI);
    }
}
