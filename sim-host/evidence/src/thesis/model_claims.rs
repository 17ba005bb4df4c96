//! Claims about the friction models themselves (4.1, 4.3).

use super::case::PLOTTED_RATIO;
use super::case::{Case, SHORT_S, TABLE_4_1};
use super::claim::{Check, Claim, number, series};
use super::{steady, sweep};
use contact::{Law, Problem, Shape, SolveError};

/// Judges all claims about the models.
pub fn claims() -> Result<Vec<Claim>, SolveError> {
    Ok(vec![coulomb_knows_one_ratio()?, lugre_becomes_dahl()?, coulomb_reduces_more(), dahl_depends(), less_at_higher_ratio()])
}

fn coulomb_knows_one_ratio() -> Result<Claim, SolveError> {
    let base = TABLE_4_1;
    let cases = [
        ("Table 4.1", base),
        ("m fivefold", Case { mass_kg: 5.0 * base.mass_kg, ..base }),
        ("Ks tenfold", Case { stiffness_n_per_m: 10.0 * base.stiffness_n_per_m, ..base }),
        ("mu fivefold", Case { mu: 5.0 * base.mu, ..base }),
        ("20 kHz", Case { frequency_hz: 20e3, ..base }),
    ];
    let labels = cases.map(|(name, _)| name.to_owned());
    let coulomb = |problem: Problem| sweep::friction(&Problem { law: Law::Coulomb, ..problem });
    let check = |condition: &str, problem: &(dyn Fn(&Case) -> Problem + Sync)| {
        let r = sweep::each(&cases, |(_, case)| coulomb(problem(case)))?;
        let spread = r.iter().map(|r_i| (r_i - r[0]).abs()).fold(0.0, f64::max);
        Ok::<_, SolveError>(Check::new(condition, spread < 1e-3, series("r", &labels, &r)))
    };
    Ok(Claim {
        id: "coulomb-knows-one-ratio",
        section: "4.1.1",
        says: "With Coulomb friction the reduction depends on the velocity ratio only: not on mass, stiffness, mu or frequency.",
        checks: vec![
            check("prescribed sinusoidal vibration, velocity ratio 0.5 (equal within 0.001)", &|case| {
                let vibration = case.vibration_m_per_s();
                case.kinematic(Shape::Sine, vibration, PLOTTED_RATIO * vibration, SHORT_S)
            })?,
            check("oscillator, first ms from rest, velocity ratio 0.5 of the forced part (equal within 0.001)", &|case| {
                case.at_ratio(PLOTTED_RATIO, SHORT_S)
            })?,
        ],
    })
}

fn coulomb_reduces_more() -> Claim {
    let grid: Vec<(f64, f64)> = [0.05, 0.1, 0.2, TABLE_4_1.kappa(), 1.0, 2.0, 4.0, 10.0, 20.0]
        .into_iter()
        .flat_map(|kappa| (1..=19).map(move |i| (0.05 * f64::from(i), kappa)))
        .collect();
    let least =
        grid.iter().map(|&(xi, kappa)| steady::dahl(xi, kappa).friction - steady::coulomb(xi)).fold(f64::INFINITY, f64::min);
    let here = steady::dahl(PLOTTED_RATIO, TABLE_4_1.kappa()).friction;
    let numbers = vec![
        number("r Dahl(0.5)", here),
        number("r Coulomb(0.5)", steady::coulomb(PLOTTED_RATIO)),
        number("smallest r Dahl - r Coulomb on the grid", least),
    ];
    let condition = format!("{} points, velocity ratios 0.05 to 0.95, kappa 0.05 to 20", grid.len());
    Claim {
        id: "coulomb-reduces-more",
        section: "4.3, Fig. 4.6",
        says: "Without system dynamics, Coulomb friction is reduced more than Dahl friction.",
        checks: vec![Check::new(condition, least > 0.0, numbers)],
    }
}

fn dahl_depends() -> Claim {
    let base = TABLE_4_1;
    let ratio = |kappa: f64| steady::dahl(PLOTTED_RATIO, kappa).friction;
    let here = ratio(base.kappa());
    let doubled = [
        ("m", Case { mass_kg: 2.0 * base.mass_kg, ..base }),
        ("mu", Case { mu: 2.0 * base.mu, ..base }),
        ("Kt", Case { contact_n_per_m: 2.0 * base.contact_n_per_m, ..base }),
    ];
    let mut numbers = vec![number("r", here)];
    for (name, case) in doubled {
        // The vibration velocity is prescribed here: the mass acts through the load only.
        let kappa = case.contact_n_per_m * base.vibration_m_per_s() / (base.omega() * case.coulomb_n());
        numbers.push(number(format!("r, {name} doubled"), ratio(kappa)));
    }
    let all_differ = numbers[1..].iter().all(|(_, r)| (r - here).abs() > 1e-3);
    Claim {
        id: "dahl-depends-on-m-mu-kt",
        section: "4.3",
        says: "With Dahl friction the reduction also depends on mass, coefficient of friction and contact stiffness.",
        checks: vec![Check::new("velocity ratio 0.5, through kappa = Kt Vv / (w mu m g) only", all_differ, numbers)],
    }
}

fn lugre_becomes_dahl() -> Result<Claim, SolveError> {
    let dahl = TABLE_4_1.at_ratio(PLOTTED_RATIO, SHORT_S);
    let reference = sweep::friction(&dahl)?;
    let lugre = |static_ratio: f64, stribeck_over_vv: f64, sigma1: f64| {
        let law = Law::Lugre {
            stiffness_n_per_m: TABLE_4_1.contact_n_per_m,
            static_ratio,
            stribeck_m_per_s: stribeck_over_vv * TABLE_4_1.vibration_m_per_s(),
            sigma1,
            sigma2: 0.0,
        };
        let mut problem = dahl.clone();
        problem.law = law;
        sweep::friction(&problem)
    };
    let (plain, fast, slow) = (lugre(1.0, 0.01, 0.0)?, lugre(1.5, 0.01, 0.0)?, lugre(1.5, 1.0, 0.0)?);
    let check = |condition: &str, r: f64, within: f64| {
        let numbers = vec![number("r LuGre", r), number("r Dahl", reference)];
        Check::new(condition, (r / reference - 1.0).abs() < within, numbers)
    };
    Ok(Claim {
        id: "lugre-becomes-dahl",
        section: "4.1.3, 4.13",
        says: "Without bristle damping and with a Stribeck velocity far below the slip velocity, LuGre friction is Dahl \
               friction.",
        checks: vec![
            check("no static peak, no damping (equal within 1e-6)", plain, 1e-6),
            check("static peak 1.5 Fc, Stribeck velocity Vv/100 (equal within 1 %)", fast, 0.01),
            check("static peak 1.5 Fc, Stribeck velocity Vv (equal within 1 %)", slow, 0.01),
        ],
    })
}

fn less_at_higher_ratio() -> Claim {
    let xi = [0.1, 0.3, 0.5, 0.7, 0.9, 1.0];
    let labels = xi.map(|xi| format!("{xi}"));
    let check = |condition: &str, r: [f64; 6]| Check::new(condition, sweep::rises(&r), series("r", &labels, &r));
    Claim {
        id: "less-reduction-at-higher-ratio",
        section: "5.1",
        says: "The reduction falls as the velocity ratio rises, and vanishes at one.",
        checks: vec![
            check("Coulomb, steady", xi.map(steady::coulomb)),
            check("Dahl, Table 4.1, 384 N, steady", xi.map(|xi| steady::dahl(xi, TABLE_4_1.kappa()).friction)),
        ],
    }
}
