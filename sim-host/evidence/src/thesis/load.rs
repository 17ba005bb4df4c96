//! Effect of the load, which is set by the mass: Figure 4.13 (4.3.3.3).

use super::StudyResult;
use super::case::{Case, SHORT_S, TABLE_4_1};
use super::claim::{Check, Claim, number, series};
use super::friction_coefficient::stored_as_printed;
use super::parametric::{FigureNames, JUDGED_RATIO, Parametric};
use super::sweep::{self, falls, rises};
use contact::SolveError;

const MASSES_KG: [f64; 5] = [0.02, 0.05, 0.1, 0.2, 1.0];

/// Computes Figure 4.13 and its claims.
pub fn study() -> Result<StudyResult, SolveError> {
    let cases: Vec<_> = MASSES_KG.iter().map(|&mass_kg| (format!("{mass_kg} kg"), Case { mass_kg, ..TABLE_4_1 })).collect();
    let data = Parametric::new(&cases)?;
    let remark = "The mass sets the load, mu m g, and also the vibration velocity; the velocity ratio is relative to that \
                  of each mass. Over a millisecond from rest a heavy mass slips less than Fc/Kt: the force does not reach \
                  its sliding value, which lowers its mean."
        .to_owned();
    let figures = data.figures(&FigureNames { number: "4-13", of: "load", remark });
    Ok(StudyResult {
        figures,
        claims: vec![friction(&data), flattens(&data), power(&data), low_ratios(&data), potential()?, stored(&data)],
    })
}

fn friction(data: &Parametric) -> Claim {
    let check = |condition: &str, r: Vec<f64>| Check::new(condition, rises(&r), series("r", &data.labels, &r));
    Claim {
        id: "load-raises-friction-ratio",
        section: "4.3.3.3, Fig. 4.13a",
        says: "A higher load raises the friction ratio.",
        checks: vec![
            check("velocity ratio 0.5, steady", data.steady(JUDGED_RATIO, |steady| steady.friction)),
            check("velocity ratio 0.5, first ms from rest", data.first_ms(JUDGED_RATIO, |ratios| Some(ratios.friction))),
            check("sliding speed fixed, first ms from rest", data.fixed_speed(|ratios| Some(ratios.friction))),
        ],
    }
}

fn flattens(data: &Parametric) -> Claim {
    let span = |low: Vec<f64>, high: Vec<f64>| low.iter().zip(&high).map(|(low, high)| high - low).collect::<Vec<f64>>();
    let check =
        |condition: &str, span: Vec<f64>| Check::new(condition, falls(&span), series("r(0.9) - r(0.1)", &data.labels, &span));
    Claim {
        id: "load-flattens",
        section: "4.3.3.3, Fig. 4.13a",
        says: "The curve of the friction ratio over the velocity ratio flattens as the load rises.",
        checks: vec![
            check("steady", span(data.steady(0.1, |steady| steady.friction), data.steady(0.9, |steady| steady.friction))),
            check(
                "first ms from rest",
                span(data.first_ms(0.1, |ratios| Some(ratios.friction)), data.first_ms(0.9, |ratios| Some(ratios.friction))),
            ),
        ],
    }
}

fn power(data: &Parametric) -> Claim {
    let check = |condition: &str, phi: Vec<f64>| Check::new(condition, falls(&phi), series("phi", &data.labels, &phi));
    Claim {
        id: "load-lowers-power-ratio",
        section: "4.3.3.3, Fig. 4.13b",
        says: "The power dissipation ratio falls as the load rises.",
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

fn low_ratios(data: &Parametric) -> Claim {
    let check = |condition: &str, phi: Vec<f64>| {
        let low = phi.iter().all(|&phi| phi < 0.5);
        Check::new(condition, low, series("phi", &data.labels, &phi))
    };
    Claim {
        id: "low-ratio-low-power",
        section: "4.3.3.3",
        says: "At low velocity ratios the power dissipated with vibration is very low (below half of the power without).",
        checks: vec![
            check("velocity ratio 0.1, steady", data.steady(0.1, |steady| steady.power)),
            check("velocity ratio 0.1, first ms from rest", data.first_ms(0.1, |ratios| ratios.power)),
        ],
    }
}

fn potential() -> Result<Claim, SolveError> {
    let check = |duration_s: f64| {
        let solution = sweep::solution(&TABLE_4_1.at_ratio(JUDGED_RATIO, duration_s))?;
        let tally = solution.tally.unwrap_or_default();
        let potential_j = tally.totals.potential_j_s / tally.time_s;
        let numbers = vec![
            number("mean potential energy [J]", potential_j),
            number("input energy [J]", tally.totals.input_j),
            number("potential/input", potential_j / tally.totals.input_j),
        ];
        let condition = format!("Table 4.1, velocity ratio 0.5, first {} ms from rest (below a tenth)", 1e3 * duration_s);
        Ok(Check::new(condition, potential_j < 0.1 * tally.totals.input_j, numbers))
    };
    Ok(Claim {
        id: "spring-energy-small",
        section: "4.3.3.3",
        says: "The energy in the spring is much smaller than the input energy.",
        checks: [SHORT_S, 10.0 * SHORT_S, 100.0 * SHORT_S].into_iter().map(check).collect::<Result<_, _>>()?,
    })
}

fn stored(data: &Parametric) -> Claim {
    let check = |condition: &str, phi: Vec<f64>| Check::new(condition, rises(&phi), series("phi_su", &data.labels, &phi));
    Claim {
        id: "load-raises-stored",
        section: "4.3.3.3",
        says: "The stored ratio phi_su rises with the load.",
        checks: vec![
            check("phi_su (4.30), velocity ratio 0.5, first ms from rest", data.first_ms(JUDGED_RATIO, stored_as_printed)),
            check("phi_su (4.30), sliding speed fixed, first ms from rest", data.fixed_speed(stored_as_printed)),
        ],
    }
}
