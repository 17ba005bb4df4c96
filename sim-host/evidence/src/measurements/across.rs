//! Vibration across the contact: a pin at several speeds, Hertz's contact until contact is lost,
//! and a tip of nanometres.

use rayon::prelude::*;

use super::data::Datum;
use super::judged::{Prediction, list};
use crate::thesis::experiment_2::compliant::Pin;
use crate::thesis::experiment_2::normal;
use contact::Shape;
use contact::compliant::{friction_ratio, popov_ratio};
use contact::empirical::EmpiricalLaw;
use contact::hertz::contact_loss_threshold;
use contact::hertz::vibration::{DrivenContact, run};
use sim::instruments::belt::law::{AMPLITUDES, LOADS_N, POINTS};

/// The two measured numbers of the pin, which determine a law with two parameters.
const PIN_NUMBERS: &[&str] = &["pin-20", "pin-87"];
/// Unknown parameter of a compliant contact.
const UNKNOWN_SPEED: &str = "sliding speed over the critical speed";
/// Remaining share of the friction below which it counts as vanished.
const VANISHED_SHARE: f64 = 0.1;
/// Amplitude just beyond the loss of contact, relative to the amplitude at which contact is lost.
const BEYOND_LOSS_RATIO: f64 = 1.01;

/// Returns the reduction by the belt's empirical law with its speed scale, scaled to the first
/// measured number of the pin; %.
pub fn empirical_percent(speed_m_per_s: f64) -> f64 {
    let law = EmpiricalLaw::FITTED;
    let of = |speed: f64| law.lasting(LOADS_N[0], speed, AMPLITUDES[1]);
    of(speed_m_per_s) / of(POINTS[2].speed_m_per_s) * POINTS[2].percent
}

/// Returns the predictions for the pin on a disc, at each speed of the data.
pub fn pin(data: &[Datum]) -> Vec<Prediction> {
    let pin = Pin::measured();
    // Hertz's mean area is independent of speed: fitted at one speed, it predicts that value at
    // all.
    let hertz = 100.0 * normal::reduction(normal::ratio_for(0.01 * POINTS[2].percent));
    let compliant =
        format!("compliant contact, A = {:.4}, critical speed {:.1} mm/s", pin.indentations, 1e3 * pin.critical_m_per_s);
    let of = |(datum, speed): (&str, f64)| {
        let popov = popov_ratio(pin.indentations, speed / pin.critical_m_per_s).map_or(f64::NAN, |ratio| 100.0 * (1.0 - ratio));
        let mut rows = vec![
            Prediction::number(datum, compliant.clone(), pin.percent(speed)).fitted_to(PIN_NUMBERS),
            Prediction::number(datum, "empirical law, its speed scale 38.3 mm/s", empirical_percent(speed))
                .fitted_to(PIN_NUMBERS),
            Prediction::number(datum, "Hertz's mean area, stiffness through 62 %", hertz).fitted_to(&["pin-20"]),
        ];
        // At the two speeds to which the model was fitted, its approximation adds nothing.
        if !PIN_NUMBERS.contains(&datum) {
            rows.push(
                Prediction::number(datum, "the paper's closed form with the same A and critical speed", popov)
                    .fitted_to(PIN_NUMBERS),
            );
        }
        rows
    };
    data.iter().filter_map(|datum| Some((datum.id.as_str(), datum.at?))).flat_map(of).collect()
}

/// Frequencies at which the mass on Hertz's contact is driven, over its small-amplitude resonance.
const DRIVE_FREQUENCY_RATIOS: [f64; 5] = [0.3, 0.6, 0.9, 1.1, 1.5];
/// Number of force steps up to the loss of contact.
const FORCE_STEPS: u32 = 60;

/// Returns the scale of the force at which contact is lost. The softening spring shifts the
/// resonance to just below one, so that small forces suffice there.
fn force_for(frequency_ratio: f64) -> f64 {
    match frequency_ratio {
        ratio if (0.8..1.0).contains(&ratio) => 0.2,
        ratio if ratio > 1.2 => 2.0,
        _ => 1.0,
    }
}

/// Returns the largest reduction of a driven mass on Hertz's contact before contact is lost.
pub fn driven_until_parting(frequency_ratio: f64) -> f64 {
    let motion = |step: u32| {
        let force_ratio = 0.02 * f64::from(step) * force_for(frequency_ratio);
        let contact = DrivenContact {
            force_ratio,
            frequency_ratio,
            damping_ratio: 0.05,
            guide_ratio: 0.0,
            start: (1.0, 0.0),
            settle_periods: 60,
            mean_periods: 40,
            steps_per_period: 200,
        };
        run(&contact, &mut |_| ())
    };
    let motions = (1..=FORCE_STEPS).map(motion).take_while(|motion| motion.reach.1 > 0.0);
    motions.map(|motion| 1.0 - motion.friction_ratio).fold(0.0, f64::max)
}

/// Returns the predictions for Hertz's contact until contact is lost.
pub fn hertz() -> Vec<Prediction> {
    let threshold = contact_loss_threshold(Shape::Sine).unwrap_or(f64::NAN);
    let driven: Vec<f64> = DRIVE_FREQUENCY_RATIOS.into_par_iter().map(driven_until_parting).collect();
    let ends = [driven.iter().copied().fold(f64::INFINITY, f64::min), driven.iter().copied().fold(0.0, f64::max)];
    vec![
        Prediction::number(
            "hertz-10",
            "Hertz's mean area, quasi-static, no free parameter",
            100.0 * normal::reduction(threshold),
        ),
        Prediction::between(
            "hertz-10",
            "a mass on Hertz's contact, damping ratio 0.05 ASSUMED, largest reduction at each of five drive frequencies \
             from 0.3 to 1.5 of its resonance",
            ends.map(|part| 100.0 * part),
            "frequency and damping of the paper's case",
        ),
        Prediction::between(
            "hertz-10",
            "compliant contact, A = 1, any sliding speed",
            [1.0, 0.0].map(|speed| 100.0 * (1.0 - friction_ratio(1.0, speed, true))),
            UNKNOWN_SPEED,
        ),
    ]
}

/// Returns the predictions for the tip of a friction force microscope.
pub fn tip() -> Vec<Prediction> {
    let threshold = contact_loss_threshold(Shape::Sine).unwrap_or(f64::NAN);
    let left = 1.0 - normal::reduction(BEYOND_LOSS_RATIO * threshold);
    // At twice the load and one amplitude d0 grows with the power 2/3 of the load, the mean
    // indentation in proportion to it.
    let half = 0.5 * threshold;
    let hertz = [half, half / 2f64.powf(2.0 / 3.0)].map(|ratio| 100.0 * normal::reduction(ratio));
    let compliant = [0.5, 0.25].map(|indentations| 100.0 * (1.0 - friction_ratio(indentations, 0.1, true)));
    let same = |[one, twice]: [f64; 2]| (twice - one).abs() < 0.1 * one;
    let numbers = |values: [f64; 2]| format!("{} % at one load and at twice the load", list(&values));
    vec![
        Prediction::sentence(
            "tip-vanishes",
            "Hertz's mean area, 1 % beyond the loss of contact, no free parameter",
            left < VANISHED_SHARE,
            format!("{:.1} % of the friction remains", 100.0 * left),
        ),
        Prediction::between(
            "tip-vanishes",
            "compliant contact, 1 % beyond the loss of contact, constant load",
            [1.0, 0.0].map(|speed| 100.0 * (1.0 - friction_ratio(BEYOND_LOSS_RATIO, speed, true))),
            UNKNOWN_SPEED,
        ),
        Prediction::sentence(
            "tip-load",
            "Hertz's mean area, half the amplitude at which contact is lost",
            same(hertz),
            numbers(hertz),
        ),
        Prediction::sentence(
            "tip-load",
            "compliant contact, A = 0.5, a tenth of the critical speed",
            same(compliant),
            numbers(compliant),
        ),
    ]
}
