//! Effect of the coefficient of friction: Figure 4.12 (4.3.3.2).

use super::StudyResult;
use super::case::{Case, TABLE_4_1};
use super::claim::{Check, Claim, series};
use super::parametric::{FigureNames, JUDGED_RATIO, Parametric};
use super::sweep::{falls, rises};
use contact::SolveError;
use contact::tally::Ratios;

const COEFFICIENTS: [f64; 4] = [0.1, 0.2, 0.3, 0.5];

/// Computes Figure 4.12 and its claims.
pub fn study() -> Result<StudyResult, SolveError> {
    let cases: Vec<_> = COEFFICIENTS.iter().map(|&mu| (format!("µ {mu}"), Case { mu, ..TABLE_4_1 })).collect();
    let data = Parametric::new(&cases)?;
    let remark = "From rest the contact must first slip by Fc/Kt (0.35 µm at µ 0.1) before the full force acts: over a \
                  millisecond this lowers the mean more for higher µ."
        .to_owned();
    let figures = data.figures(&FigureNames { number: "4-12", of: "friction coefficient", remark });
    Ok(StudyResult { figures, claims: vec![friction(&data), power(&data), parts(&data)] })
}

fn friction(data: &Parametric) -> Claim {
    let check = |condition: &str, r: Vec<f64>| Check::new(condition, rises(&r), series("r", &data.labels, &r));
    Claim {
        id: "mu-raises-friction-ratio",
        section: "4.3.3.2, Fig. 4.12a",
        says: "The friction ratio rises with the coefficient of friction.",
        checks: vec![
            check("velocity ratio 0.5, steady", data.steady(JUDGED_RATIO, |steady| steady.friction)),
            check("velocity ratio 0.5, first ms from rest", data.first_ms(JUDGED_RATIO, |ratios| Some(ratios.friction))),
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
            check("velocity ratio 0.5, steady, mean(F V)/(Fc Vt)", data.steady(JUDGED_RATIO, |steady| steady.power)),
            check("velocity ratio 0.5, first ms, mean(F V)/(Fc Vt)", data.first_ms(JUDGED_RATIO, |ratios| ratios.power)),
            check(
                "velocity ratio 0.5, first ms, by 4.35 as printed",
                data.first_ms(JUDGED_RATIO, |ratios| ratios.power_as_printed),
            ),
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
            check("phi_iu, velocity ratio 0.5, steady", "phi_iu", data.steady(JUDGED_RATIO, |steady| steady.input())),
            check("phi_iu, velocity ratio 0.5, first ms from rest", "phi_iu", data.first_ms(JUDGED_RATIO, |ratios| ratios.input)),
            check(
                "phi_su (4.30), velocity ratio 0.5, first ms from rest",
                "phi_su",
                data.first_ms(JUDGED_RATIO, stored_as_printed),
            ),
        ],
    }
}

/// Returns phi_su by 4.30 and 4.35, from the ratio that 4.35 prints.
pub fn stored_as_printed(ratios: &Ratios) -> Option<f64> {
    Some(1.0 + ratios.input? - ratios.power_as_printed?)
}
