//! Number of bending resonances of the free square sheet.
//!
//! At high frequencies a plate of area S has `S/2 sqrt(m'/D)` modes per hertz, with any edges (L.
//! Cremer, M. Heckl, *Structure-Borne Sound*). Single modes are estimated by one product of beam
//! functions (G. B. Warburton, *The vibration of rectangular plates*, 1954).

use std::f64::consts::PI;

use super::sheet::{QUALITY, SIDE_M, Sheet};

/// Returns the modes per hertz by Cremer and Heckl, 1/Hz.
pub fn density_per_hz(sheet: &Sheet, side_m: f64) -> f64 {
    0.5 * side_m * side_m / sheet.c_m2_per_s()
}

/// Returns the number of modes within the bandwidth f/Q of one mode.
pub fn overlap(frequency_hz: f64) -> f64 {
    density_per_hz(&Sheet::PLATE, SIDE_M) * frequency_hz / QUALITY
}

/// Returns Warburton's coefficients G, H, J of a direction with free ends and a number of nodal
/// lines across it.
fn coefficients(lines: u32) -> [f64; 3] {
    let s = f64::from(lines) - 0.5;
    match lines {
        0 => [0.0, 0.0, 0.0],
        1 => [0.0, 0.0, 12.0 / (PI * PI)],
        2 => [1.506, 1.248, 5.017],
        _ => [s, s * s * (1.0 - 2.0 / (s * PI)), s * s * (1.0 + 6.0 / (s * PI))],
    }
}

/// Returns `w a^2 sqrt(m'/D)` of the mode of a free square plate with a number of nodal lines in
/// each direction.
fn parameter(across: u32, along: u32, poisson: f64) -> f64 {
    let [gx, hx, jx] = coefficients(across);
    let [gy, hy, jy] = coefficients(along);
    PI * PI * (gx.powi(4) + gy.powi(4) + 2.0 * (poisson * hx * hy + (1.0 - poisson) * jx * jy)).sqrt()
}

/// Counts the modes between two frequencies, Hz, by Warburton.
pub fn counted(from_hz: f64, to_hz: f64) -> usize {
    let sheet = Sheet::PLATE;
    let hertz = |m: u32, n: u32| parameter(m, n, sheet.poisson) * sheet.c_m2_per_s() / (2.0 * PI * SIDE_M * SIDE_M);
    let all = (0..40).flat_map(|m| (0..40).map(move |n| (m, n)));
    // Bending modes have two nodal lines or more in one direction, or one in each; the others are
    // rigid-body motions.
    all.filter(|&(m, n)| m + n >= 2).filter(|&(m, n)| (from_hz..to_hz).contains(&hertz(m, n))).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A. W. Leissa, *The free vibration of rectangular plates*, 1973: 13.489, 19.789, 24.432,
    /// 35.024 at a Poisson's ratio of 0.3. One product of beam functions is some per cent too
    /// stiff, and gives only the mean of the second and third.
    #[test]
    fn the_lowest_modes_are_near_those_of_leissa() {
        let near =
            |found: f64, expected: f64, within: f64| assert!((found / expected - 1.0).abs() < within, "{found} {expected}");
        near(parameter(1, 1, 0.3), 13.489, 0.06);
        near(parameter(2, 0, 0.3), 0.5 * (19.789 + 24.432), 0.02);
        near(parameter(2, 1, 0.3), 35.024, 0.05);
    }

    /// With supported edges the modes are known: `k^2 = (pi/a)^2 (m^2 + n^2)`. Their density tends
    /// to that of the formula.
    #[test]
    fn the_density_is_that_of_a_supported_plate() {
        let sheet = Sheet::PLATE;
        let limit_hz = 4e6;
        let r2 = (sheet.wave_number(limit_hz) * SIDE_M / PI).powi(2);
        let count = (1..400).flat_map(|m| (1..400).map(move |n| m * m + n * n)).filter(|&s| f64::from(s) < r2).count();
        let expected = density_per_hz(&sheet, SIDE_M) * limit_hz;
        // The edges remove about a k/pi = 115 of 11 500 modes.
        assert!((count as f64 / expected - 1.0).abs() < 0.02, "{count} {expected}");
    }

    #[test]
    fn warburton_agrees_with_the_mode_density() {
        let expected = density_per_hz(&Sheet::PLATE, SIDE_M) * 40e3;
        let found = counted(10e3, 50e3) as f64;
        // Free edges add modes: 127 are counted instead of 115.
        assert!((found / expected - 1.0).abs() < 0.15, "{found} {expected}");
    }
}
