//! The bending wave of the sheet: B.10 to B.12, and the limits of the thin beam.

use std::f64::consts::TAU;

use super::sheet::{SHEAR_PA, Sheet};
use super::{MEASURED_HZ, electrodes};
use crate::thesis::claim::{Check, Claim, number};
use crate::thesis::picture::{dashed, figure as draw, line, ranged};
use crate::thesis::sweep;
use report::{Figure, Marker};

/// Share of a rectangular section that carries shear (Reissner).
const SHEAR_SHARE: f64 = 5.0 / 6.0;
/// Largest relative deviation of another theory.
const NEAR_REL: f64 = 0.05;

/// Returns the wave number with shear and rotary inertia, rad/m (S. Timoshenko 1921): the larger
/// root of `EI k^4 - rho I w^2 (1 + E/(s G)) k^2 - rho A w^2 + rho^2 I w^4/(s G) = 0`, per width.
pub fn timoshenko(sheet: &Sheet, frequency_hz: f64) -> f64 {
    let omega2 = (TAU * frequency_hz).powi(2);
    let (h, rho) = (sheet.thickness_m, sheet.density_kg_per_m3);
    let inertia = rho * h.powi(3) / 12.0;
    let stiffness = sheet.stiffness_n_m();
    let shear_n_per_m = SHEAR_SHARE * SHEAR_PA * h;
    let linear = omega2 * (inertia + rho * h * stiffness / shear_n_per_m);
    let constant = rho * h * omega2 * (inertia * omega2 / shear_n_per_m - 1.0);
    ((linear + (linear * linear - 4.0 * stiffness * constant).sqrt()) / (2.0 * stiffness)).sqrt()
}

/// Returns the rotation of the section over the slope of the middle, with shear: the factor on u of
/// B.13.
pub fn rotation_share(sheet: &Sheet, frequency_hz: f64) -> f64 {
    let k = timoshenko(sheet, frequency_hz);
    1.0 - sheet.density_kg_per_m3 * (TAU * frequency_hz / k).powi(2) / (SHEAR_SHARE * SHEAR_PA)
}

/// Draws the wave number over frequency.
pub fn figure() -> Figure {
    let khz = sweep::spaced(1.0, 60.0, 119);
    let of = |k: &dyn Fn(f64) -> f64| khz.iter().map(|khz| k(1e3 * khz)).collect();
    let pattern = electrodes::Pattern::PRINTED.wave_number();
    let series = vec![
        line("beam (B.12)", "k_beam_rad_per_m", &khz, of(&|hz| Sheet::BEAM.wave_number(hz))),
        line("plate, Poisson's ratio 0.35", "k_plate_rad_per_m", &khz, of(&|hz| Sheet::PLATE.wave_number(hz))),
        dashed("beam with shear", "k_timoshenko_rad_per_m", &khz, of(&|hz| timoshenko(&Sheet::BEAM, hz))),
    ];
    let caption = "Free bending wave of the sheet of Figure B.8. The horizontal line is the wave number of the electrodes, \
                   four tabs a wave. The free wave has it at 9 kHz, neither at 20 nor at 40 kHz. Assumed: Poisson's ratio \
                   and shear modulus of PZT-5A, as Figure B.8 does not give them."
        .into();
    let axes = [ranged("frequency [kHz]", 0.0, 60.0), ranged("wave number [rad/m]", 0.0, 700.0)];
    let mut drawn = draw("app-b-wave-number", "Appendix B (B.12): wave number of the sheet", caption, axes, series);
    drawn.hlines = vec![(pattern, "four tabs a wave".into())];
    drawn.markers = MEASURED_HZ
        .map(|hz| {
            let k = Sheet::BEAM.wave_number(hz);
            Marker { x: hz / 1e3, y: k, label: format!("{k:.0} rad/m") }
        })
        .to_vec();
    drawn
}

/// Computes the fourth derivative of a sine of wave number k over the sine, by differences of seven
/// points: k^4.
fn fourth_difference(k: f64) -> f64 {
    const WEIGHTS: [f64; 7] = [-1.0, 12.0, -39.0, 56.0, -39.0, 12.0, -1.0];
    let step = 0.05 / k;
    let x = 1.0 / k;
    let w = |x: f64| (k * x).sin();
    let sum: f64 = WEIGHTS.iter().zip(-3..).map(|(weight, i)| weight * w(x + f64::from(i) * step)).sum();
    sum / (6.0 * step.powi(4) * w(x))
}

/// Judges B.12 and its assumptions.
pub fn claim() -> Claim {
    let beam = Sheet::BEAM;
    let left = MEASURED_HZ.map(|hz| {
        let (k, omega2) = (beam.wave_number(hz), (TAU * hz).powi(2));
        (beam.c_m2_per_s().powi(2) * fourth_difference(k) / omega2 - 1.0).abs()
    });
    let off = |k: &dyn Fn(f64) -> f64| MEASURED_HZ.map(|hz| k(hz) / beam.wave_number(hz) - 1.0);
    let check = |condition: &str, off: [f64; 2]| {
        let numbers = vec![number("k over that of B.12, minus one, 20 kHz", off[0]), number("40 kHz", off[1])];
        Check::new(condition, off.iter().all(|off| off.abs() < NEAR_REL), numbers)
    };
    let mut solves = Check::new(
        "B.11 with this k inserted into B.10, by differences (residual below 1e-6)",
        left.iter().all(|left| *left < 1e-6),
        vec![number("residual at 20 kHz", left[0]), number("40 kHz", left[1])],
    );
    solves.numbers.extend(MEASURED_HZ.map(|hz| number(format!("k at {} kHz [rad/m]", hz / 1e3), beam.wave_number(hz))));
    Claim {
        id: "bending-wave-number",
        section: "B.2.1, B.10-B.12",
        says: "The stator's wave is that of a thin beam: k = w^(1/2) (rho S/EI)^(1/4).",
        checks: vec![
            solves,
            check(
                "a plate, wide compared with the wave, Poisson's ratio 0.35 (within 5 %)",
                off(&|hz| Sheet::PLATE.wave_number(hz)),
            ),
            check("with shear and rotary inertia (within 5 %)", off(&|hz| timoshenko(&beam, hz))),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thin_sheet_has_no_shear() {
        let thin = Sheet { thickness_m: 1e-5, ..Sheet::BEAM };
        // The correction is of the order (k h)^2, here 5e-3 times that of the prototype.
        assert!((timoshenko(&thin, 20e3) / thin.wave_number(20e3) - 1.0).abs() < 3e-4);
        assert!((rotation_share(&thin, 20e3) - 1.0).abs() < 1e-3);
    }

    /// First order of the correction: k grows by (k h)^2 (1 + E/(s G))/48.
    #[test]
    fn shear_slows_the_wave_to_first_order() {
        let thin = Sheet { thickness_m: 1e-4, ..Sheet::BEAM };
        let kh = thin.wave_number(20e3) * thin.thickness_m;
        let expected = kh * kh * (1.0 + thin.modulus_pa / (SHEAR_SHARE * SHEAR_PA)) / 48.0;
        let found = timoshenko(&thin, 20e3) / thin.wave_number(20e3) - 1.0;
        assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    }

    #[test]
    fn differences_are_the_fourth_derivative() {
        assert!((fourth_difference(500.0) / 500f64.powi(4) - 1.0).abs() < 1e-6);
    }
}
