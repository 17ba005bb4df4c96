//! Friction switch: its law compared with the host's closed form, and its use of nominal values and
//! measurements.

use contact::closed;
use firmware::act::friction::dahl::{coulomb, friction_ratio};
use firmware::act::friction::inverse::solve;
use firmware::board::command::Command;
use firmware::seam::block::Orders;
use firmware::seam::block::Target;
use firmware::seam::refusal::Refusal;
use scene::load::load;
use sim::instruments::View;
use sim::instruments::friction_switch::Step;
use sim::instruments::measure;
use sim::metrics::Metrics;
use sim::record::Record;
use sim::run::{Watch, run};

fn velocity_ratios() -> impl Iterator<Item = f32> {
    (1..200).map(|n| 0.005 * n as f32).chain([1e-4, 1e-3, 0.9990, 0.9999])
}

fn kappas() -> impl Iterator<Item = f32> {
    (-48..=64).map(|n| 10f32.powf(0.125 * n as f32)).chain([0.0, 1e12, f32::INFINITY])
}

/// Compares single precision with six nodes and double precision with up to twenty, from no memory
/// to no stiffness. Measured: 6.2e-6.
#[test]
fn the_law_agrees_with_the_closed_form() {
    let mut worst = (0.0f64, 0.0, 0.0);
    for xi in velocity_ratios() {
        for kappa in kappas() {
            let error = f64::from(friction_ratio(xi, kappa)) - closed::friction_ratio(xi.into(), kappa.into());
            worst = if error.abs() > worst.0 { (error.abs(), xi, kappa) } else { worst };
        }
    }
    println!("worst {worst:?}");
    assert!(worst.0 < 7e-6, "{worst:?}");
}

/// By the closed form, the drive of the inverse has the target ratio. Measured: 1.002e-4; the
/// solution stops at 1e-4.
#[test]
fn the_inverse_leads_back_to_the_closed_form() {
    let mut worst = (0.0f64, 0.0, 0.0);
    for lambda in kappas() {
        for n in 1..200 {
            let target = 0.005 * n as f32;
            let solution = solve(target, lambda, 0.05);
            let ratio = closed::friction_ratio(solution.xi.into(), (lambda / solution.xi).into());
            let error = (ratio - f64::from(target.max(solution.floor))).abs();
            worst = if error > worst.0 { (error, target, lambda) } else { worst };
        }
    }
    println!("worst {worst:?}");
    assert!(worst.0 < 1.05e-4, "{worst:?}");
}

/// The error of the Coulomb law is the reference: driven by its inverse, a soft contact has a ratio
/// up to 0.39 above its target. Measured: 0.387.
#[test]
fn the_coulomb_inverse_errs_as_it_is_said_to() {
    let errors = velocity_ratios().map(|xi| closed::friction_ratio(xi.into(), 1e-6) - f64::from(coulomb(xi)));
    let worst = errors.fold(0.0, f64::max);
    assert!((worst - 0.387).abs() < 0.001, "{worst}");
    for target in [0.2f32, 0.5, 0.9] {
        let xi = solve(target, f32::INFINITY, 0.05).xi;
        assert!((xi - (0.5 * std::f32::consts::PI * target).sin()).abs() < 2e-4, "{target}: {xi}");
    }
}

#[test]
fn invalid_targets_are_refused() {
    let orders = Orders::default();
    let odd = [f32::NAN, f32::INFINITY, -0.1];
    for bad in odd.map(Target::Ratio).into_iter().chain(odd.map(Target::Force)).chain([Target::Ratio(1.1)]) {
        assert_eq!(Command::Friction(Some(bad)).applied_to(&orders), Err(Refusal::NotPlausible), "{bad:?}");
    }
    for good in [None, Some(Target::Ratio(0.0)), Some(Target::Ratio(1.0)), Some(Target::Force(3.0))] {
        let next = Command::Friction(good).applied_to(&orders).unwrap().unwrap();
        assert_eq!((next.friction, next.sequence), (good, 1));
    }
}

/// Runs a short scene with one ratio after the survey.
fn switched(changes: &[&str]) -> (Metrics, Vec<Step>, Record) {
    let short = ["duration_s=0.6", "controller.friction.step_s=[]", "controller.friction.step_ratio=[]"];
    let sets: Vec<String> = short.iter().chain(changes).map(|&set| set.to_owned()).collect();
    let loaded = load("friction-ratio", &sets).unwrap_or_else(|error| panic!("{error}"));
    let scene = loaded.scene.driven().unwrap();
    let record = run(&scene, Watch::default()).unwrap();
    (measure(&scene, &record), View::new(&scene, &record).steps(), record)
}

/// The speed of the encoder is used, not the nominal one.
#[test]
fn the_speed_of_the_encoder_is_used() {
    let (_, steps, _) = switched(&["sensors.encoder_counts_per_mm=100", "controller.friction.speed_m_per_s=0.06"]);
    assert!(steps.len() == 1 && steps[0].error().abs() < 0.005, "{steps:?}");
}

#[test]
fn a_force_is_held_by_the_force_channel() {
    let (_, steps, _) = switched(&["controller.friction.target_force_n=0.072"]);
    assert!((steps[0].set_point - 0.5).abs() < 1e-3 && steps[0].error().abs() < 0.01, "{steps:?}");
}

/// A load of 10 N on a contact stiffer than any in the campaign reduces the amplitude by a sixth;
/// the loop restores it.
#[test]
fn a_heavy_load_follows_the_same_law() {
    let (metrics, steps, _) = switched(&[
        "rig.slider.load_n=10",
        "contact.dahl.stiffness_n_per_m=6e6",
        "sensors.force_noise_n=0.06",
        "controller.friction.target_ratio=0.5",
    ]);
    assert!(steps[0].error().abs() < 0.01 && steps[0].limit == 0, "{steps:?} {metrics:?}");
}

/// The belt is faster than the tip can be: limit 102, and silence, which has the same friction.
#[test]
fn missing_authority_is_reported_and_silent() {
    let fast = ["rig.slider.speed_m_per_s=0.2", "controller.friction.speed_m_per_s=0.2"];
    let (_, _, record) = switched(&fast);
    let last = record.rows.last().unwrap();
    assert_eq!((last.limit, last.fault, last.drive_v), (102, 0, 0.0));
    assert!(last.friction.is_some());
}

/// Without a force channel there is no survey, so the friction ratio is only as accurate as the
/// nominal contact.
#[test]
fn without_a_force_channel_the_nominal_contact_is_used() {
    let nominal = ["controller.friction.dahl_length_m=0.5e-6", "controller.friction.speed_m_per_s=0.038"];
    let text = include_str!("../sim-host/scene/scenes/friction-ratio.toml")
        .replace("force_hz = 500", "")
        .replace("force_noise_n = 0.003", "");
    let sets = ["duration_s=0.4", "controller.friction.step_s=[]", "controller.friction.step_ratio=[]"];
    let sets: Vec<String> = sets.iter().chain(&nominal).map(|&set| set.to_owned()).collect();
    let loaded = scene::load::load_text("without", &text, &sets).unwrap_or_else(|error| panic!("{error}"));
    let scene = loaded.scene.driven().unwrap();
    let record = run(&scene, Watch::default()).unwrap();
    let steps = View::new(&scene, &record).steps();
    assert!(record.rows.last().unwrap().friction.is_some_and(|belief| !belief.identified));
    assert!(steps[0].error().abs() < 0.01, "{steps:?}");
}
