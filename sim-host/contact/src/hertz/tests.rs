//! Comparison with Hess and Soom's threshold, with a sum over the period, and with the limits.

use std::f64::consts::{PI, TAU};

use super::*;

const LOADED: HertzProblem = HertzProblem { normal_n: 270.0, stiffness_n_per_m15: 1e12, amplitude_m: 0.0, shape: Shape::Sine };

fn at(shape: Shape, ratio: f64) -> HertzSolution {
    let static_m = (LOADED.normal_n / LOADED.stiffness_n_per_m15).powf(2.0 / 3.0);
    solve(&HertzProblem { amplitude_m: ratio * static_m, shape, ..LOADED }).unwrap()
}

/// Threshold a / d0 = (3 pi / (8 sqrt 2))^(2/3), at which mean d = a.
#[test]
fn contact_is_lost_at_the_published_amplitude() {
    let exact = (3.0 * PI / (8.0 * 2f64.sqrt())).powf(2.0 / 3.0);
    let got = contact_loss_threshold(Shape::Sine).unwrap();
    assert!((got - exact).abs() < 1e-15 && (exact - 0.885_341).abs() < 5e-7, "{got}");
    let solution = at(Shape::Sine, exact);
    assert!((solution.friction_ratio - exact).abs() < 1e-15 && (1.0 - exact - 0.11466).abs() < 5e-6, "{solution:?}");
    assert_eq!(at(Shape::Sine, 0.999 * exact).contact_share, 1.0);
    assert!(at(Shape::Sine, 1.001 * exact).contact_share < 1.0);
    // Square: (2 a)^1.5 / 2 = 1; straight lines: (2 a)^2.5 / (5 a) = 1.
    assert!((contact_loss_threshold(Shape::Square).unwrap() - 0.5f64.cbrt()).abs() < 1e-15);
    assert!((contact_loss_threshold(Shape::Triangle).unwrap() - (5.0 / 2f64.powf(2.5)).powf(2.0 / 3.0)).abs() < 1e-15);
    assert_eq!(contact_loss_threshold(Shape::Random { hold_s: 1.0, seed: 1 }), None);
}

/// Reductions from a separate study, in per cent.
#[test]
fn reductions_beyond_contact_loss() {
    for (ratio, reduction, near) in
        [(2.0, 23.5, 0.05), (5.0, 33.0, 0.5), (10.0, 39.0, 0.5), (50.0, 50.0, 0.5), (100.0, 54.0, 0.5)]
    {
        let got = 100.0 * (1.0 - at(Shape::Sine, ratio).friction_ratio);
        println!("{ratio}: {got}");
        assert!((got - reduction).abs() < near, "{ratio}: {got}");
    }
    assert!((at(Shape::Sine, 100.0).contact_share - 0.11).abs() < 5e-3);
}

/// Independent check: sums over the period with the D of the solution must give back the load.
#[test]
fn the_mean_force_is_the_load() {
    let places = 400_000;
    for shape in [Shape::Sine, Shape::Square, Shape::Sawtooth, Shape::Triangle] {
        for ratio in [0.1, 0.7, 0.885, 0.9, 1.5, 4.0, 30.0] {
            let solution = at(shape, ratio);
            let waveform = Waveform::new(shape, ratio * solution.static_deflection_m, 1.0, 1.0);
            let (mut force, mut area, mut contact) = (0.0, 0.0, 0.0);
            for i in 0..places {
                let d = solution.mean_deflection_m + waveform.value((f64::from(i) + 0.5) / f64::from(places));
                let d = d.max(0.0) / solution.static_deflection_m;
                (force, area) = (force + d.powf(1.5), area + d);
                contact += if d > 0.0 { 1.0 } else { 0.0 };
            }
            let [force, area, contact] = [force, area, contact].map(|sum| sum / f64::from(places));
            assert!((force - 1.0).abs() < 2e-9, "{shape:?} {ratio}: {force}");
            assert!((area - solution.friction_ratio).abs() < 2e-9, "{shape:?} {ratio}: {area} {solution:?}");
            assert!((contact - solution.contact_share).abs() < 2e-5, "{shape:?} {ratio}: {contact} {solution:?}");
        }
    }
}

/// Compares the elliptic form with a trapezium sum over the contact arc, on both sides of the
/// switch between the forms and across the threshold.
#[test]
fn formulas_agree_at_their_boundaries() {
    for modulus in [0.3f64, 0.5, 0.7, 0.9] {
        // Contact arc with 4000 places, which suffice at these moduli.
        let mean = (0..4000)
            .map(|i| {
                let (sine, cosine) = (0.5 * PI * (f64::from(i) + 0.5) / 4000.0).sin_cos();
                cosine.powi(4) / (1.0 - modulus * sine * sine).sqrt()
            })
            .sum::<f64>()
            / 4000.0;
        let arc = 2f64.powf(1.5) * modulus * modulus * mean;
        let got = Spread::Cosine.mean_force(2.0 * modulus, 1.0);
        assert!((got / arc - 1.0).abs() < 2e-14, "{modulus}: {got} {arc}");
    }
    let [before, behind] = [2.0 + 1e-9, 2.0 - 1e-9].map(|lift| Spread::Cosine.mean_force(lift, 1.0));
    assert!((before - behind).abs() < 1e-8 && (before / behind - 1.0) > 0.0);
}

#[test]
fn limits() {
    for shape in [Shape::Sine, Shape::Square, Shape::Sawtooth, Shape::Triangle, Shape::Still] {
        assert!((at(shape, 0.0).friction_ratio - 1.0).abs() < 1e-15, "{shape:?}");
    }
    // Small amplitudes: the reduction is mean w^2 a^2 / 4, from mean (1 + e)^(3/2) = 1 + 3 e / 2 +
    // 3 e^2 / 8.
    for shape in [Shape::Sine, Shape::Square, Shape::Sawtooth] {
        let lowered = 1.0 - at(shape, 1e-3).friction_ratio;
        let expected = 0.25e-6 * Waveform::shape_rms(shape).powi(2);
        assert!((lowered / expected - 1.0).abs() < 1e-5, "{shape:?}: {lowered} {expected}");
    }
    // Beyond its threshold the square is in contact for half of the time at 2^(2/3) d0.
    for ratio in [0.8, 3.0, 1e3] {
        assert!((at(Shape::Square, ratio).friction_ratio - 0.5f64.cbrt()).abs() < 1e-12, "{ratio}");
    }
    // Friction falls with the amplitude for every shape.
    for shape in [Shape::Sine, Shape::Triangle] {
        let mut before = 1.0;
        for step in 1..200 {
            let now = at(shape, 1.05f64.powi(step) * 0.01).friction_ratio;
            assert!(now < before, "{shape:?} {step}");
            before = now;
        }
    }
}

#[test]
fn period_for_plots_and_refused_problems() {
    let problem = HertzProblem { amplitude_m: 1e-6, ..LOADED };
    let solution = solve(&problem).unwrap();
    let points = period(&problem, &solution);
    let mean = points[1..].iter().map(|point| point.normal_n).sum::<f64>() / f64::from(PERIOD_STEPS);
    assert!((mean / 270.0 - 1.0).abs() < 1e-4 && points.len() == 257, "{mean}");
    assert!((points[64].deflection_m - solution.mean_deflection_m - 1e-6 * (TAU / 4.0).cos()).abs() < 1e-20);
    for bad in [
        HertzProblem { normal_n: 0.0, ..LOADED },
        HertzProblem { amplitude_m: f64::NAN, ..LOADED },
        HertzProblem { shape: Shape::Random { hold_s: 1.0, seed: 1 }, ..LOADED },
    ] {
        assert!(solve(&bad).is_err(), "{bad:?}");
    }
}
