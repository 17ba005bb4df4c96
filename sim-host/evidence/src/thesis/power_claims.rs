//! Claims about the power dissipation ratio itself (4.3.2).

use super::StudyResult;
use super::case::{Case, SHORT_S, TABLE_4_1};
use super::claim::{Check, Claim, number};
use super::parametric::JUDGED_RATIO;
use super::sweep;
use contact::SolveError;

/// Judges the claims, which have no figure.
pub fn study() -> Result<StudyResult, SolveError> {
    Ok(StudyResult { figures: Vec::new(), claims: vec![printed()?, depends()?] })
}

fn printed() -> Result<Claim, SolveError> {
    let check = |milliseconds: f64| {
        let ratios = sweep::ratios(&TABLE_4_1.at_ratio(JUDGED_RATIO, milliseconds * SHORT_S))?;
        let (direct, printed) = (ratios.power.unwrap_or(f64::NAN), ratios.power_as_printed.unwrap_or(f64::NAN));
        let numbers = vec![number("mean(F V)/(Fc Vt)", direct), number("1 + phi_iu - phi_su", printed)];
        let condition = format!("velocity ratio 0.5, first {milliseconds} ms from rest (equal within 1 %)");
        Ok(Check::new(condition, (printed / direct - 1.0).abs() < 0.01, numbers))
    };
    Ok(Claim {
        id: "power-ratio-equation",
        section: "4.3.2, 4.35",
        says: "The power dissipation ratio is 1 + phi_iu - phi_su.",
        checks: [1.0, 10.0, 100.0].into_iter().map(check).collect::<Result<_, _>>()?,
    })
}

fn depends() -> Result<Claim, SolveError> {
    let base = TABLE_4_1;
    let cases = [
        ("Table 4.1", base),
        ("m doubled", Case { mass_kg: 2.0 * base.mass_kg, ..base }),
        ("Ks tenfold", Case { stiffness_n_per_m: 10.0 * base.stiffness_n_per_m, ..base }),
        ("Kt doubled", Case { contact_n_per_m: 2.0 * base.contact_n_per_m, ..base }),
        ("Fe doubled", Case { force_n: 2.0 * base.force_n, ..base }),
        ("mu doubled", Case { mu: 2.0 * base.mu, ..base }),
    ];
    let phi = sweep::each(&cases, |(_, case)| {
        let ratios = sweep::ratios(&case.at_ratio(JUDGED_RATIO, SHORT_S))?;
        Ok(ratios.power.unwrap_or(f64::NAN))
    })?;
    let numbers = cases.iter().zip(&phi).map(|((name, _), &phi)| number(format!("phi({name})"), phi)).collect();
    let all_differ = phi[1..].iter().all(|phi_i| (phi_i / phi[0] - 1.0).abs() > 0.01);
    Ok(Claim {
        id: "power-ratio-depends",
        section: "4.3.2",
        says: "The power dissipation ratio depends on mass, system and contact stiffness, control force and mu.",
        checks: vec![Check::new(
            "velocity ratio 0.5 of each case's own vibration, first ms from rest (by more than 1 %)",
            all_differ,
            numbers,
        )],
    })
}
