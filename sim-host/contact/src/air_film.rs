//! Upper bound of the air film that a belt drags between itself and a ring.
//!
//! ```text
//! h = 0.643 R (6 eta U / T)^(2/3)        A. Eshel, H. G. Elrod, J. Basic Eng. 87 (1965) 831: the foil bearing
//! ```
//!
//! `R` is the radius, `U` the speed, `T` the tension over the width, `eta` the viscosity of air.
//! The formula holds for h far below R and far above the mean free path of air. The belt must have
//! no bending stiffness, be smooth and airtight, and be wide compared with its arc.
//!
//! Webbing is rough, woven and porous, and leaks at its edges. For webbing the formula is therefore
//! an upper bound, and a film thinner than the roughness carries no load.

/// Viscosity of air at 20 °C, Pa s.
pub const AIR_VISCOSITY_PA_S: f64 = 1.81e-5;
/// Mean free path of air at 20 °C and one atmosphere, m. The formula does not hold for thinner
/// films.
pub const MEAN_FREE_PATH_M: f64 = 68e-9;
/// Factor of the foil-bearing formula, dimensionless.
const FOIL_FACTOR: f64 = 0.643;

/// Returns the film thickness, m, for a radius, m, a speed, m/s, and a tension over the width, N/m.
pub fn thickness_m(radius_m: f64, speed_m_per_s: f64, tension_n_per_m: f64) -> f64 {
    FOIL_FACTOR * radius_m * (6.0 * AIR_VISCOSITY_PA_S * speed_m_per_s.abs() / tension_n_per_m).powf(2.0 / 3.0)
}

/// Returns the speed at which the film has this thickness, m/s.
pub fn speed_m_per_s(radius_m: f64, thickness_m: f64, tension_n_per_m: f64) -> f64 {
    (thickness_m / (FOIL_FACTOR * radius_m)).powf(1.5) * tension_n_per_m / (6.0 * AIR_VISCOSITY_PA_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tape of 35 N/m over a head of 20 mm at 2.5 m/s: 0.643 x 0.02 x (6 x 1.81e-5 x 2.5 /
    /// 35)^(2/3) = 5.04e-6 m, by hand.
    #[test]
    fn a_tape_floats_on_air() {
        let film = thickness_m(0.02, 2.5, 35.0);
        assert!((film - 5.04e-6).abs() < 5e-9, "{film}");
        assert!(film > 5.0 * MEAN_FREE_PATH_M);
    }

    #[test]
    fn the_speed_is_the_inverse() {
        for thickness in [1e-8, 20e-6] {
            let speed = speed_m_per_s(0.01, thickness, 47e3);
            assert!((thickness_m(0.01, speed, 47e3) / thickness - 1.0).abs() < 1e-12);
        }
    }

    /// A seat belt at its load limiter would need more than 10 km/s for a film as thick as its 20
    /// um threads.
    #[test]
    fn webbing_does_not_float() {
        assert!(thickness_m(0.01, 3.0, 2200.0 / 0.047) < MEAN_FREE_PATH_M);
        assert!(speed_m_per_s(0.01, 20e-6, 2200.0 / 0.047) > 1e4);
    }
}
