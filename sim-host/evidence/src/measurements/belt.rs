//! A seat belt under a horn (experiment 2): the empirical law as in its scene, Hertz's contact and
//! the compliant contact.

use super::judged::{Prediction, list};
use crate::thesis::driven;
use crate::thesis::experiment_2::compliant::Belt;
use crate::thesis::experiment_2::normal::{self, Hertz};
use contact::SolveError;
use contact::empirical::reached;
use sim::instruments::belt::law::{AMPLITUDES, Curve, FULL_M, LAG_S, LOADS_N, POINTS};

const NUMBER_DATA: &[&str] = &["belt-58", "belt-55"];
const ALL_DATA: &[&str] = &["belt-58", "belt-55", "belt-load", "belt-amplitude-270", "belt-amplitude-450"];
/// Data that are sentences, in the order of `Curve::statements` without its first, which concerns
/// the lag alone.
const SENTENCE_DATA: [&str; 3] = ["belt-load", "belt-amplitude-270", "belt-amplitude-450"];

/// Returns Hertz's contact with the stiffness fitted to the first number, and the lag that was
/// fitted to the thesis's words.
pub fn hertz() -> Curve {
    let contact = Hertz::through(0.01 * POINTS[0].percent / reached(1.0, 2.0, LAG_S));
    Curve {
        name: "Hertz's mean area, stiffness through 58 %".into(),
        lasting: Box::new(move |load, _, amplitude| contact.reduction(load, amplitude * FULL_M)),
        lag_s: LAG_S,
    }
}

/// Returns the reduction of the scene at 70 % amplitude, %.
fn scene_reduction_percent(load_n: f64) -> Result<f64, SolveError> {
    let sets = [format!("rig.belt.load_n={load_n}"), format!("rig.belt.amplitude_fraction={}", AMPLITUDES[1])];
    driven::run_scene("experiment-2", &sets)?.metric("reduction_percent")
}

/// Returns the predictions for the statements of experiment 2.
pub fn predictions() -> Result<Vec<Prediction>, SolveError> {
    let (hertz, fitted) = (hertz(), Curve::fitted());
    let numbers = |model: &str, [light, heavy]: [f64; 2], to: &'static [&'static str]| {
        [Prediction::number("belt-58", model, light).fitted_to(to), Prediction::number("belt-55", model, heavy).fitted_to(to)]
    };
    let at = |curve: &Curve| [LOADS_N[0], LOADS_N[2]].map(|load| curve.percent(load, AMPLITUDES[1], 2.0));
    let scene = [scene_reduction_percent(LOADS_N[0])?, scene_reduction_percent(LOADS_N[2])?];
    let sheet = |pa: f64| 100.0 * normal::reduction(AMPLITUDES[1] * FULL_M / normal::sheet_m(pa));
    let mut rows = numbers("scene experiment-2: empirical law", scene, ALL_DATA).to_vec();
    rows.extend(numbers(&hertz.name, at(&hertz), &["belt-58"]));
    rows.push(Prediction::between(
        "belt-58",
        "Hertz's mean area, a sheet of nylon under the horn, from woven (100 MPa) to solid (2.8 GPa)",
        [normal::WOVEN_PA, normal::SOLID_PA].map(sheet),
        "the stiffness across the webbing",
    ));
    rows.extend(sentences("empirical law", &fitted, ALL_DATA));
    rows.extend(sentences(&hertz.name, &hertz, &["belt-58"]));
    if let Some(belt) = Belt::measured() {
        let curve = belt.curve();
        let model = "compliant contact, both stiffnesses through both numbers";
        rows.extend(numbers(model, at(&curve), NUMBER_DATA));
        rows.extend(sentences(model, &curve, NUMBER_DATA));
    }
    Ok(rows)
}

fn sentences(model: &str, curve: &Curve, to: &'static [&'static str]) -> Vec<Prediction> {
    let met = curve.statements().map(|statement| statement.met);
    let over = |amplitude: f64| list(&LOADS_N.map(|load| curve.percent(load, amplitude, 2.0)));
    let gains = |load: f64| format!("{:.2} points", curve.gain(load));
    let numbers =
        [format!("50 %: {} %; 70 %: {} %", over(AMPLITUDES[0]), over(AMPLITUDES[1])), gains(LOADS_N[0]), gains(LOADS_N[1])];
    let of = |(index, numbers): (usize, String)| {
        Prediction::sentence(SENTENCE_DATA[index], model, met[index + 1], numbers).fitted_to(to)
    };
    numbers.into_iter().enumerate().map(of).collect()
}
