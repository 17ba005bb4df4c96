//! Comparison of the law along the wrap with its limits, with plain sums, and with another method
//! for the tension.

use std::f64::consts::{FRAC_2_PI, TAU};

use super::normal::{Normal, NormalPart, Stiffnesses};
use super::ode::Sliding;
use super::table::{Table, Tensioned};
use super::{Pull, Ring};
use crate::plane::coulomb;

const MU: f64 = 0.3;
const FLOOR: f64 = 0.13 / 0.3;
/// Directions in the plane of the wrap, and out of it, degrees.
const DIRECTIONS: [(f64, f64); 7] = [(0.0, 0.0), (90.0, 0.0), (165.0, 0.0), (-40.0, 0.5), (20.0, 30.0), (0.0, 85.0), (0.0, 90.0)];
const FITTED: Normal = Normal { amplitude_m: 40e-6, radius_m: 8e-3 };

fn ring(wrap_deg: f64, floor: f64, direction: (f64, f64)) -> Ring {
    Ring::new(wrap_deg, MU, floor, direction).unwrap()
}

fn in_surface(ring: &Ring, z: f64) -> f64 {
    let found = ring.exponent(z, None, Pull::Shoulder);
    assert!(found.error_rad < 1e-11, "{ring:?} {z}: {found:?}");
    found.in_surface_rad
}

#[test]
fn no_wrap_or_no_vibration_gives_the_capstan_equation() {
    for direction in DIRECTIONS {
        assert_eq!(in_surface(&ring(0.0, 0.0, direction), 0.5), 0.0);
        for wrap_deg in [1.0, 90.0, 150.0, 360.0, 720.0] {
            let ring = ring(wrap_deg, 0.0, direction);
            assert!((in_surface(&ring, f64::INFINITY) / ring.wrap_rad - 1.0).abs() < 1e-15);
            // Without sliding the friction ratio is zero at every position, for any direction.
            assert!(in_surface(&ring, 0.0).abs() < 1e-15);
        }
    }
}

#[test]
fn along_the_axis_every_position_has_the_transverse_law() {
    for z in [1e-6, 0.1, 1.0, 30.0] {
        let ring = ring(150.0, 0.0, (33.0, 90.0));
        let law = coulomb::friction_ratio(z, 90.0);
        assert!((in_surface(&ring, z) / ring.wrap_rad - law).abs() < 1e-15, "{z}");
    }
}

/// A short wrap under a vibration along it has the longitudinal law; one whose middle is normal to
/// the vibration has nearly full friction.
#[test]
fn a_short_wrap_has_the_law_of_its_middle() {
    let along = ring(0.01, 0.0, (90.0, 0.0));
    assert!((in_surface(&along, 0.5) / along.wrap_rad - FRAC_2_PI * 0.5f64.asin()).abs() < 1e-8);
    let across = ring(0.01, 0.0, (0.0, 0.0));
    assert!((in_surface(&across, 0.5) / across.wrap_rad - 1.0).abs() < 1e-15);
}

/// Plain midpoint sum of the law at eight million positions; its error is of order 1.5 in the step
/// at a root of the law.
#[test]
fn the_integral_is_a_plain_sum() {
    const PLACES: u32 = 8_000_000;
    for (wrap_deg, direction, floor, z) in [
        (150.0, (0.0, 0.0), 0.0, 0.3),
        (150.0, (0.0, 0.0), FLOOR, 0.3),
        (90.0, (135.0, 0.0), FLOOR, 0.8),
        (270.0, (10.0, 0.0), 0.0, 0.05),
    ] {
        let ring = ring(wrap_deg, floor, direction);
        let step = ring.wrap_rad / f64::from(PLACES);
        let law = |i: u32| {
            let tangential = (step * (f64::from(i) + 0.5) - 0.5 * ring.wrap_rad - ring.angle_rad).sin().abs();
            (if z < tangential { FRAC_2_PI * (z / tangential).asin() } else { 1.0 }).max(floor)
        };
        let sum: f64 = (0..PLACES).map(law).sum::<f64>() * step;
        let found = in_surface(&ring, z);
        assert!((found - sum).abs() < 1e-9, "{wrap_deg} {direction:?} {z}: {found} for {sum}");
    }
}

/// Returns the mean over a period of a vibration along all three axes at a position, with the slip
/// as a vector and the normal force of a contact that is never lost.
fn mean(parts: super::Parts, z: f64, indentations: f64) -> f64 {
    const PHASES: u32 = 1 << 14;
    let at = |i: u32| {
        let (sine, cosine) = (TAU * (f64::from(i) + 0.5) / f64::from(PHASES)).sin_cos();
        let (along, across) = (z - parts.tangential * sine, -parts.transverse * sine);
        (1.0 + indentations * parts.normal * cosine) * along / along.hypot(across)
    };
    (0..PHASES).map(at).sum::<f64>() / f64::from(PHASES)
}

#[test]
fn a_stiff_contact_knows_no_normal_part() {
    for (direction, z) in [((20.0, 30.0), 0.3), ((-70.0, 60.0), 1.0), ((0.0, 45.0), 0.05)] {
        let ring = ring(150.0, 0.0, direction);
        for place in [-1.3, -0.4, 0.0, 0.9] {
            let law = ring.in_surface(place, z);
            for indentations in [0.0, 0.4, 1.0] {
                let mean = mean(ring.parts(place), z, indentations);
                assert!((mean - law).abs() < 1e-12, "{direction:?} {place} {indentations}: {mean} for {law}");
            }
        }
    }
}

/// Tension stepped along the wrap in half a million steps, with an error of second order at a kink
/// of the law.
#[test]
fn the_tension_is_that_of_steps_along_the_wrap() {
    let hz = 20e3;
    for (direction, speed, low_n, pull) in [
        ((20.0, 30.0), 0.025, 300.0, Pull::Shoulder),
        ((20.0, 30.0), 0.5, 2200.0, Pull::Retractor),
        ((-60.0, 10.0), 1.5, 5.0, Pull::Shoulder),
        ((0.0, 70.0), 3.0, 700.0, Pull::Retractor),
    ] {
        let ring = ring(150.0, FLOOR, direction);
        let sliding = Sliding { speed_m_per_s: speed, tip_m_per_s: 5.0, hz, low_n, pull, in_surface: true };
        let fitted = NormalPart::Fitted(FITTED);
        let (found, error) = ring.tension_exponent(&fitted, &sliding);
        let reference = ring.stepped_exponent(500_000, &fitted, &sliding);
        assert!((found - reference).abs() < 1e-9 && error < 1e-9, "{direction:?}: {found} {error:e} for {reference}");
        // Bernoulli's equation in closed form.
        let closed = ring.fitted_exponent(speed, 5.0, &FITTED, (low_n, pull));
        assert!((closed - found).abs() < 1e-11, "{direction:?}: {closed} for {found}");
        let stiff = Stiffnesses { normal_n_per_m: 1.134e7, tangential_n_per_m: 7.6e6 };
        let compliant = NormalPart::Compliant(FITTED, stiff);
        let (found, error) = ring.tension_exponent(&compliant, &sliding);
        let reference = ring.stepped_exponent(100_000, &compliant, &sliding);
        assert!((found - reference).abs() < 1e-8 && error < 1e-9, "compliant, {direction:?}: {found} {error:e} for {reference}");
    }
}

/// One table serves all tensions and amplitudes: the equation, evaluated at the velocity ratio from
/// the table, returns the friction ratio that was looked up.
#[test]
fn the_table_is_the_inverse_of_the_exponent() {
    for direction in DIRECTIONS {
        for (wrap_deg, floor) in [(150.0, FLOOR), (90.0, 0.0), (270.0, 0.2)] {
            for normal in [None, Some(FITTED)] {
                let ring = ring(wrap_deg, floor, direction);
                let began = std::time::Instant::now();
                let table = Table::new(ring, normal);
                let made = began.elapsed();
                let (mut worst, angle) = (0.0f64, MU * ring.wrap_rad);
                for (pull, low_n, amplitude) in [(Pull::Shoulder, 2200.0, 1.0), (Pull::Retractor, 40.0, 0.1)] {
                    for step in 1..60 {
                        let ratio = floor + (1.0 - floor) * f64::from(step) / 60.0;
                        let tip = 5.0;
                        let z = table.velocity_ratio(&Tensioned { ratio, low_n, pull }, tip, amplitude);
                        let found = match &normal {
                            None => MU * in_surface(&ring, z),
                            Some(normal) => {
                                let found = ring.exponent(z, Some(normal), pull);
                                let effect = amplitude * super::normal::fitted_effect(amplitude * tip * z);
                                MU * found.in_surface_rad + ring.fitted_loss(found.fitted_rad, effect, normal, low_n)
                            }
                        };
                        worst = worst.max((found / angle - ratio).abs());
                    }
                }
                println!(
                    "{direction:?} {wrap_deg} {floor:.2} {}: {:?} panels in {made:.1?}, {worst:.1e}",
                    normal.is_some(),
                    table.panels()
                );
                assert!(worst < 1e-9, "{direction:?} {wrap_deg} {floor} {}: {worst:e}", normal.is_some());
            }
        }
    }
}

/// The integrals of a table, whose panels are judged by their coefficients, equal those of panels
/// that are compared with their halves.
#[test]
fn the_integrals_of_a_table_are_the_exponents() {
    let mut worst = 0.0f64;
    for direction in DIRECTIONS {
        for (wrap_deg, floor) in [(150.0, FLOOR), (90.0, 0.0), (270.0, 0.2), (33.0, 0.01), (700.0, 0.8)] {
            let ring = ring(wrap_deg, floor, direction);
            for step in 0..200 {
                // From 1e-6 to 76, densest near 1e-2; every other value is on a linear grid.
                let z = 10f64.powf(-2.0 + 4.0 * (f64::from(step) / 100.0 - 1.0).powi(3));
                let z = if step % 2 == 0 { z } else { f64::from(step) / 180.0 };
                let [in_surface, shoulder, retractor] = ring.integrals(z, Some(&FITTED));
                let of = |pull: Pull| ring.exponent(z, Some(&FITTED), pull);
                let (by_shoulder, by_retractor) = (of(Pull::Shoulder), of(Pull::Retractor));
                let off = [
                    in_surface - by_shoulder.in_surface_rad,
                    shoulder - by_shoulder.fitted_rad,
                    retractor - by_retractor.fitted_rad,
                ];
                worst = off.into_iter().fold(worst, |worst, off| worst.max(off.abs()));
                let [alone, ..] = ring.integrals(z, None);
                worst = worst.max((alone - by_shoulder.in_surface_rad).abs());
                assert!(worst < 2e-11, "{direction:?} {wrap_deg} {floor} {z}: {off:?}");
            }
        }
    }
    println!("{worst:.1e}");
}

/// Tests the floor, which is left at a certain velocity ratio, and the ratio of one, which is
/// reached only along the sliding.
#[test]
fn the_ends_of_the_table_are_those_of_the_law() {
    let needed = |ratio: f64| Tensioned { ratio, low_n: 100.0, pull: Pull::Shoulder };
    // The middle is normal to the vibration, so the floor is left at zero.
    let radial = Table::new(ring(150.0, FLOOR, (0.0, 0.0)), None);
    assert_eq!(radial.velocity_ratio(&needed(FLOOR), 1.0, 1.0), 0.0);
    assert!((radial.velocity_ratio(&needed(1.0), 1.0, 1.0) - 75f64.to_radians().sin()).abs() < 1e-4);
    // No position is normal: the floor is left first where the tangential part is smallest.
    let along = Table::new(ring(90.0, FLOOR, (90.0, 0.0)), None);
    let least = 45f64.to_radians().cos() * (0.25 * TAU * FLOOR).sin();
    assert!((along.velocity_ratio(&needed(FLOOR), 1.0, 1.0) / least - 1.0).abs() < 1e-12);
    let axis = Table::new(ring(150.0, FLOOR, (0.0, 90.0)), None);
    let far = axis.velocity_ratio(&needed(1.0 - 1e-8), 1.0, 1.0);
    assert!((coulomb::friction_ratio(far, 90.0) - (1.0 - 1e-8)).abs() < 1e-11, "{far}");
}

#[test]
fn errors_name_the_value_out_of_range() {
    for (wrap, mu, floor, direction, said) in [
        (721.0, MU, 0.0, (0.0, 0.0), "the angle of wrap is 721 degrees, and must be from 0 to 720 degrees"),
        (150.0, f64::NAN, 0.0, (0.0, 0.0), "coefficient of friction"),
        (150.0, MU, 1.5, (0.0, 0.0), "smallest friction ratio is 1.5"),
        (150.0, MU, 0.0, (400.0, 0.0), "direction of the vibration is 400"),
        (150.0, MU, 0.0, (0.0, 91.0), "out of the plane of the wrap is 91 degrees, and must be from 0 to 90"),
    ] {
        let error = Ring::new(wrap, mu, floor, direction).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}
