//! Self-excitation of the oscillator by sliding friction (4.2, 4.3.1).

use super::case::PLOTTED_RATIO;
use super::case::{Case, TABLE_4_1};
use super::claim::{Check, Claim, number};
use super::sweep;
use super::trace::amplitude_over_time;
use contact::{Law, Problem, Sign, SolveError};

/// Length of the runs, s.
const RUN_S: f64 = 0.2;
/// Length of a bin, s.
const BIN_S: f64 = 10e-3;

/// Judges the claims about self-excited oscillation.
pub fn claims() -> Result<Vec<Claim>, SolveError> {
    let vibration = TABLE_4_1.vibration_m_per_s();
    let speed = PLOTTED_RATIO * vibration;
    let literal = Case { sign: Sign::Literal, ..TABLE_4_1 };
    let runs = [
        TABLE_4_1.unexcited(0.0, speed, RUN_S),
        literal.unexcited(0.0, speed, RUN_S),
        TABLE_4_1.unexcited(vibration, speed, RUN_S),
        literal.unexcited(vibration, speed, RUN_S),
        stribeck(Sign::Passive),
        stribeck(Sign::Literal),
    ];
    let amplitudes = sweep::each(&runs, |problem| Ok(amplitude_over_time(problem, TABLE_4_1.natural_hz(), BIN_S)?.1))?;
    let names = [
        "Dahl, from rest, passive sign",
        "Dahl, from rest, literal sign",
        "Dahl, from x' = 0.0534 m/s, passive sign",
        "Dahl, from x' = 0.0534 m/s, literal sign",
        "LuGre, falling Stribeck curve, Kt a thousandfold, from rest, passive sign",
        "LuGre, falling Stribeck curve, Kt a thousandfold, from rest, literal sign",
    ];
    let excited = Claim {
        id: "self-excited-oscillation",
        section: "4.2, 4.3.1",
        says: "Without excitation, friction excites an oscillation by itself.",
        checks: names.iter().zip(&amplitudes).map(|(name, amplitudes)| grows(name, amplitudes)).collect(),
    };
    let first = |run: usize| amplitudes[run].first().copied().unwrap_or(f64::NAN);
    Ok(vec![excited, small(first(0), vibration), friction_sets_amplitude(speed)?])
}

/// Returns the late over the early natural part of an initial oscillation, with the passive and the
/// literal sign.
pub fn first_and_last() -> Result<[f64; 2], SolveError> {
    let vibration = TABLE_4_1.vibration_m_per_s();
    let change = |sign: Sign| {
        let problem = Case { sign, ..TABLE_4_1 }.unexcited(vibration, PLOTTED_RATIO * vibration, RUN_S);
        let (_, amplitudes) = amplitude_over_time(&problem, TABLE_4_1.natural_hz(), BIN_S)?;
        Ok::<_, SolveError>(amplitudes.last().copied().unwrap_or(f64::NAN) / amplitudes.first().copied().unwrap_or(f64::NAN))
    };
    Ok([change(Sign::Passive)?, change(Sign::Literal)?])
}

/// Returns a contact whose friction falls with speed, at the speed of its steepest fall; its
/// stiffness makes friction follow the speed at once.
fn stribeck(sign: Sign) -> Problem {
    let stribeck_m_per_s = 1e-3;
    let stiffness_n_per_m = 1000.0 * TABLE_4_1.contact_n_per_m;
    let mut problem = Case { sign, ..TABLE_4_1 }.unexcited(0.0, stribeck_m_per_s / 2f64.sqrt(), RUN_S);
    problem.law = Law::Lugre { stiffness_n_per_m, static_ratio: 1.5, stribeck_m_per_s, sigma1: 0.0, sigma2: 0.0 };
    problem
}

fn grows(condition: &str, amplitudes: &[f64]) -> Check {
    let (first, last) = (amplitudes.first().copied().unwrap_or(f64::NAN), amplitudes.last().copied().unwrap_or(f64::NAN));
    let numbers = vec![
        number("natural part, first 10 ms [m/s]", first),
        number("natural part, 190-200 ms [m/s]", last),
        number("last/first", last / first),
    ];
    // A smaller change is numerical noise: without a reversal the amplitude stays constant.
    Check::new(condition, last > 1.01 * first, numbers)
}

fn small(amplitude: f64, vibration: f64) -> Claim {
    let case = TABLE_4_1;
    let bound = case.coulomb_n() / (case.mass_kg * case.stiffness_n_per_m).sqrt();
    let numbers = vec![
        number("natural part from rest, first 10 ms [m/s]", amplitude),
        number("bound Fc/sqrt(m Ks) [m/s]", bound),
        number("bound over Vv at 384 N", bound / vibration),
    ];
    Claim {
        id: "free-oscillation-is-small",
        section: "4.3.1",
        says: "Oscillation caused by friction alone is very small and may not contribute to friction reduction.",
        checks: vec![Check::new(
            "Table 4.1, from rest, passive sign (below a hundredth of Vv)",
            amplitude < bound && bound < 0.01 * vibration,
            numbers,
        )],
    }
}

fn friction_sets_amplitude(speed: f64) -> Result<Claim, SolveError> {
    let case = TABLE_4_1;
    let cases = [
        ("Table 4.1", case),
        ("mu doubled", Case { mu: 2.0 * case.mu, ..case }),
        ("Kt tenfold", Case { contact_n_per_m: 10.0 * case.contact_n_per_m, ..case }),
        ("Kt a thousandfold", Case { contact_n_per_m: 1000.0 * case.contact_n_per_m, ..case }),
    ];
    let amplitudes = sweep::each(&cases, |(_, case)| {
        let (_, amplitudes) = amplitude_over_time(&case.unexcited(0.0, speed, BIN_S), case.natural_hz(), BIN_S)?;
        Ok(amplitudes.first().copied().unwrap_or(f64::NAN))
    })?;
    let numbers =
        cases.iter().zip(&amplitudes).map(|((name, _), &amplitude)| number(format!("{name} [m/s]"), amplitude)).collect();
    Ok(Claim {
        id: "friction-sets-free-amplitude",
        section: "4.3.3.4",
        says: "The amplitude of friction-induced oscillation depends on the friction force, and thereby on contact stiffness.",
        checks: vec![Check::new("from rest, first 10 ms", amplitudes[1..].iter().all(|&a| a > 1.05 * amplitudes[0]), numbers)],
    })
}
