//! Effect of the coefficient of friction: Figure 4.12 (4.3.3.2).

use super::Part;
use super::case::{Case, TABLE_4_1};
use super::claim::{Check, Claim, series};
use super::parametric::{JUDGED, Names, Parametric};
use super::sweep::{falls, rises};
use contact::SolveError;
use contact::tally::Ratios;

const COEFFICIENTS: [f64; 4] = [0.1, 0.2, 0.3, 0.5];

/// Figure 4.12 with its claims.
pub fn study() -> Result<Part, SolveError> {
    let cases: Vec<_> = COEFFICIENTS.iter().map(|&mu| (format!("µ {mu}"), Case { mu, ..TABLE_4_1 })).collect();
    let data = Parametric::new(&cases)?;
    let remark = "From rest the contact must first slip by Fc/Kt (0.35 µm at µ 0.1) before the force is there at all: over a \
                  millisecond that lowers the mean the more, the higher µ is."
        .to_owned();
    let figures = data.figures(&Names { number: "4-12", of: "friction coefficient", remark });
    Ok(Part { figures, claims: vec![friction(&data), power(&data), parts(&data)] })
}

fn friction(data: &Parametric) -> Claim {
    let check = |condition: &str, r: Vec<f64>| Check::new(condition, rises(&r), series("r", &data.labels, &r));
    Claim {
        id: "mu-raises-friction-ratio",
        section: "4.3.3.2, Fig. 4.12a",
        says: "The friction ratio rises with the coefficient of friction.",
        checks: vec![
            check("velocity ratio 0.5, steady", data.steady(JUDGED, |steady| steady.friction)),
            check("velocity ratio 0.5, first ms from rest", data.first_ms(JUDGED, |ratios| Some(ratios.friction))),
        ],
    }
}

fn power(data: &Parametric) -> Claim {
    let check = |condition: &str, phi: Vec<f64>| Check::new(condition, falls(&phi), series("phi", &data.labels, &phi));
    Claim {
        id: "mu-lowers-power-ratio",
        section: "4.3.3.2, Fig. 4.12b",
        says: "The power dissipation ratio falls as the coefficient of friction rises.",
        checks: vec![
            check("velocity ratio 0.5, steady, mean(F V)/(Fc Vt)", data.steady(JUDGED, |steady| steady.power)),
            check("velocity ratio 0.5, first ms, mean(F V)/(Fc Vt)", data.first_ms(JUDGED, |ratios| ratios.power)),
            check("velocity ratio 0.5, first ms, by 4.35 as printed", data.first_ms(JUDGED, |ratios| ratios.power_as_printed)),
        ],
    }
}

fn parts(data: &Parametric) -> Claim {
    let check = |condition: &str, name: &str, phi: Vec<f64>| Check::new(condition, falls(&phi), series(name, &data.labels, &phi));
    Claim {
        id: "mu-lowers-input-and-stored",
        section: "4.3.3.2",
        says: "A high coefficient of friction means a low input ratio phi_iu and a low stored ratio phi_su.",
        checks: vec![
            check("phi_iu, velocity ratio 0.5, steady", "phi_iu", data.steady(JUDGED, |steady| steady.input())),
            check("phi_iu, velocity ratio 0.5, first ms from rest", "phi_iu", data.first_ms(JUDGED, |ratios| ratios.input)),
            check("phi_su (4.30), velocity ratio 0.5, first ms from rest", "phi_su", data.first_ms(JUDGED, stored_as_printed)),
        ],
    }
}

/// phi_su as 4.30 and 4.35 have it, from the ratio that 4.35 prints.
pub fn stored_as_printed(ratios: &Ratios) -> Option<f64> {
    Some(1.0 + ratios.input? - ratios.power_as_printed?)
}
