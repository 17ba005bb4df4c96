//! The law of a compliant contact in its two numbers: the paper's closed form next to the model,
//! and the effect of the held quantity beyond the loss of contact.

use std::f64::consts::TAU;

use contact::compliant::{CompliantProblem, Press, friction_ratio, popov_ratio, solve};
use report::TableBlock;

/// Returns both tables: the closed form next to the model, and the effect of the held quantity.
pub fn tables() -> Vec<TableBlock> {
    let speeds = [0.0, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0];
    let row = |&speed: &f64| {
        let (model, paper) = (friction_ratio(1.0, speed, true), popov_ratio(1.0, speed).unwrap_or(f64::NAN));
        vec![speed.to_string(), format!("{model:.6}"), format!("{paper:.6}"), format!("{:+.4}", paper - model)]
    };
    let worst = (0..=1000)
        .map(|i| 1e-3 * f64::from(i))
        .map(|speed| friction_ratio(1.0, speed, true) - popov_ratio(1.0, speed).unwrap_or(f64::NAN));
    let caption = format!(
        "Friction ratio at A = 1; at any smaller A the reduction is proportional to A. Largest difference over a thousand \
         speeds: {:.4}.",
        worst.map(f64::abs).fold(0.0, f64::max)
    );
    let closed = TableBlock::new(
        "compliant-closed-form",
        "The paper's closed form and the model",
        &caption,
        &["s", "model", "closed form", "closed form less model"],
        speeds.iter().map(row).collect(),
    );
    let row = |&(indentations, speed): &(f64, f64)| {
        let of = |press: Press| {
            let unit = 1.0 / TAU;
            let problem = CompliantProblem {
                mu: 1.0,
                press,
                normal_n_per_m: 1.0,
                tangential_n_per_m: 1.0,
                amplitude_m: indentations,
                frequency_hz: unit,
                sliding_m_per_s: speed * indentations,
            };
            solve(&problem).ok()
        };
        let (load, indentation) = (of(Press::Load(1.0)), of(Press::Indentation(1.0)));
        let shown = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.4}"));
        vec![
            indentations.to_string(),
            speed.to_string(),
            shown(load.and_then(|found| found.friction_ratio)),
            shown(load.map(|found| found.critical_m_per_s / indentations)),
            shown(load.map(|found| found.contact_share)),
            shown(indentation.and_then(|found| found.friction_ratio)),
            shown(indentation.map(|found| found.coefficient_ratio)),
            shown(indentation.map(|found| found.contact_share)),
        ]
    };
    let cases =
        [0.5, 1.0, 2.0, 3.0, 10.0, 100.0].into_iter().flat_map(|indentations| [0.1, 0.6].map(|speed| (indentations, speed)));
    let held = TableBlock::new(
        "compliant-held",
        "Load or indentation held, beyond the loss of contact",
        "A is the amplitude over the indentation without vibration, s the sliding speed over mu kz w a / kx. The friction ratio \
         refers to the normal force without vibration. With the indentation held the mean normal force rises; the coefficient \
         ratio refers to that mean. The critical speed with the load held is in the unit of s; with the indentation held it is 1.",
        &[
            "A",
            "s",
            "load held: friction ratio",
            "critical speed",
            "time in contact",
            "indentation held: friction ratio",
            "coefficient ratio",
            "time in contact",
        ],
        cases.collect::<Vec<_>>().iter().map(row).collect(),
    );
    vec![closed, held]
}
