//! Effect of the control force: Figure 4.11 (4.3.3.1).

use super::StudyResult;
use super::case::{Case, TABLE_4_1};
use super::claim::{Check, Claim, series};
use super::parametric::{FigureNames, JUDGED_RATIO, Parametric};
use super::sweep::{falls, rises};
use contact::SolveError;

/// Control forces, N, up to the largest of Table 4.1.
const FORCES_N: [f64; 6] = [192.0, 384.0, 768.0, 1152.0, 1536.0, 1920.0];

/// Computes Figure 4.11 and its claims.
pub fn study() -> Result<StudyResult, SolveError> {
    let cases: Vec<_> = FORCES_N.iter().map(|&force_n| (format!("{force_n} N"), Case { force_n, ..TABLE_4_1 })).collect();
    let data = Parametric::new(&cases)?;
    let remark = "Control forces up to the 1920 N of Table 4.1; κ is proportional to the force.".to_owned();
    let figures = data.figures(&FigureNames { number: "4-11", of: "control force", remark });
    Ok(StudyResult { figures, claims: vec![friction(&data), power(&data), power_at_low_ratios(&data)] })
}

fn friction(data: &Parametric) -> Claim {
    let check = |condition: &str, r: Vec<f64>| Check::new(condition, falls(&r), series("r", &data.labels, &r));
    Claim {
        id: "force-lowers-friction",
        section: "4.3.3.1, Fig. 4.11a",
        says: "A higher control force lowers the friction ratio.",
        checks: vec![
            check("velocity ratio 0.5, steady", data.steady(JUDGED_RATIO, |steady| steady.friction)),
            check("velocity ratio 0.5, first ms from rest", data.first_ms(JUDGED_RATIO, |ratios| Some(ratios.friction))),
            check("sliding speed fixed, first ms from rest", data.fixed_speed(|ratios| Some(ratios.friction))),
        ],
    }
}

fn power(data: &Parametric) -> Claim {
    let check = |condition: &str, phi: Vec<f64>| Check::new(condition, rises(&phi), series("phi", &data.labels, &phi));
    Claim {
        id: "force-raises-power",
        section: "4.3.3.1, Fig. 4.11b",
        says: "A higher control force raises the power dissipation ratio.",
        checks: vec![
            check("velocity ratio 0.5, steady, mean(F V)/(Fc Vt)", data.steady(JUDGED_RATIO, |steady| steady.power)),
            check("velocity ratio 0.5, first ms, mean(F V)/(Fc Vt)", data.first_ms(JUDGED_RATIO, |ratios| ratios.power)),
            check(
                "velocity ratio 0.5, first ms, by 4.35 as printed",
                data.first_ms(JUDGED_RATIO, |ratios| ratios.power_as_printed),
            ),
            check("sliding speed fixed, first ms, mean(F V)/(Fc Vt)", data.fixed_speed(|ratios| ratios.power)),
        ],
    }
}

fn power_at_low_ratios(data: &Parametric) -> Claim {
    let ratios = [0.1, 0.3, 0.5, 0.7, 0.9];
    let labels = ratios.map(|xi| format!("{xi}"));
    // Curve of the thesis's plots, 384 N.
    let at = |of: &dyn Fn(f64) -> Vec<f64>| ratios.map(|xi| of(xi)[1]);
    let input = at(&|xi| data.steady(xi, |steady| steady.input()));
    let power = at(&|xi| data.steady(xi, |steady| steady.power));
    Claim {
        id: "low-ratio-needs-power",
        section: "4.3.3.1",
        says: "Lower velocity ratios need much more power.",
        checks: vec![
            Check::new("power fed into the vibration, phi_iu, 384 N, steady", falls(&input), series("phi_iu", &labels, &input)),
            Check::new("power dissipation ratio itself, 384 N, steady", falls(&power), series("phi", &labels, &power)),
        ],
    }
}
