//! Comparison of the models: Figure 4.16 (4.3.4), without measurements, as the thesis's text gives
//! none.

use super::case::{SHORT_S, TABLE_4_1};
use super::claim::{Check, Claim, number, series};
use super::picture::{FRICTION_RATIO, VELOCITY_RATIO, dashed, figure, line, ranged};
use super::{StudyResult, steady, sweep};
use contact::SolveError;

/// Time after which the start transient is negligible, s: five time constants of the natural part,
/// whose square matters.
const SETTLED_S: f64 = 0.8;
const LOW_RATIOS: [f64; 3] = [0.1, 0.2, 0.3];

/// Computes Figure 4.16 and its claims.
pub fn study() -> Result<StudyResult, SolveError> {
    let xi = sweep::spaced(0.01, 1.0, 100);
    let kappa = TABLE_4_1.kappa();
    let from_rest = |xi: f64, duration_s: f64| sweep::friction(&TABLE_4_1.at_ratio(xi, duration_s));
    let short = sweep::each(&xi, |&xi| from_rest(xi, SHORT_S))?;
    let medium = sweep::each(&xi, |&xi| from_rest(xi, 10.0 * SHORT_S))?;
    let dahl = xi.iter().map(|&xi| steady::dahl(xi, kappa).friction).collect();
    let caption = "Table 4.1, 384 N. The thesis compares its model with measurements of Littmann et al.; its text gives no \
                   measured value, so none is shown. Chosen here: from rest, passive sign, the stated window, velocity \
                   ratio relative to the steady vibration velocity. In the steady state the oscillator's curve is Dahl's."
        .into();
    let series = vec![
        line("Coulomb", "coulomb", &xi, xi.iter().map(|&xi| steady::coulomb(xi)).collect()),
        line("Dahl", "dahl", &xi, dahl),
        dashed("oscillator with Dahl, 0-1 ms", "oscillator_1_ms", &xi, short),
        dashed("oscillator with Dahl, 0-10 ms", "oscillator_10_ms", &xi, medium),
    ];
    let axes = [ranged(VELOCITY_RATIO, 0.0, 1.0), ranged(FRICTION_RATIO, 0.0, 1.0)];
    let figure =
        figure("fig-4-16", "Figure 4.16: comparison of the models (no measured data in the text)", caption, axes, series);
    Ok(StudyResult { figures: vec![figure], claims: vec![conforms()?, zero()?] })
}

/// Returns the friction ratio of the oscillator after its start transient has decayed.
pub fn settled(velocity_ratio: f64) -> Result<f64, SolveError> {
    let mut problem = TABLE_4_1.at_ratio(velocity_ratio, SETTLED_S);
    problem.window_s.0 = 0.9 * SETTLED_S;
    sweep::friction(&problem)
}

fn conforms() -> Result<Claim, SolveError> {
    let labels = LOW_RATIOS.map(|xi| format!("{xi}"));
    let coulomb = LOW_RATIOS.map(steady::coulomb);
    let dahl = LOW_RATIOS.map(|xi| steady::dahl(xi, TABLE_4_1.kappa()).friction);
    let short = sweep::each(&LOW_RATIOS, |&xi| sweep::friction(&TABLE_4_1.at_ratio(xi, SHORT_S)))?;
    let long = sweep::each(&LOW_RATIOS, |&xi| settled(xi))?;
    let check = |condition: &str, ours: &[f64], theirs: &[f64]| {
        let above = ours.iter().zip(theirs).all(|(ours, theirs)| *ours > theirs + 1e-4);
        let numbers = [series("r oscillator", &labels, ours), series("r compared with", &labels, theirs)].concat();
        Check::new(condition, above, numbers)
    };
    Ok(Claim {
        id: "system-model-conforms",
        section: "4.3.4, Fig. 4.16",
        says: "Measurements lie above the models at low velocity ratios, and the system model is closer to them (it lies \
               higher).",
        checks: vec![
            check("against Coulomb, first ms from rest", &short, &coulomb),
            check("against Dahl, first ms from rest", &short, &dahl),
            check("against Dahl, steady", &long, &dahl),
        ],
    })
}

fn zero() -> Result<Claim, SolveError> {
    let ratios = [1e-1, 1e-2, 1e-3];
    let labels = ratios.map(|xi| format!("{xi}"));
    // A floor would stop the fall; without a floor the ratio falls tenfold a decade.
    let check = |condition: &str, r: Vec<f64>| {
        let floor = r.windows(2).any(|pair| pair[1] > 0.5 * pair[0]);
        Check::new(condition, floor, series("r", &labels, &r))
    };
    let late = |xi: f64| {
        let mut problem = TABLE_4_1.at_ratio(xi, 20.0 * SHORT_S);
        problem.window_s.0 = 10.0 * SHORT_S;
        sweep::friction(&problem)
    };
    let mut claim = Claim {
        id: "zero-friction-unattainable",
        section: "4.3.4, 4.5",
        says: "System dynamics keep the friction ratio from approaching zero arbitrarily closely.",
        checks: vec![
            check("oscillator from rest, 10-20 ms", sweep::each(&ratios, |&xi| late(xi))?),
            check(
                "oscillator from rest, first ms",
                sweep::each(&ratios, |&xi| sweep::friction(&TABLE_4_1.at_ratio(xi, SHORT_S)))?,
            ),
            check("Dahl, steady", ratios.map(|xi| steady::dahl(xi, TABLE_4_1.kappa()).friction).to_vec()),
        ],
    };
    if let Some(steady) = claim.checks.last_mut() {
        steady.numbers.push(number("slope r/xi at 0.001", steady::dahl(1e-3, TABLE_4_1.kappa()).friction / 1e-3));
    }
    Ok(claim)
}
