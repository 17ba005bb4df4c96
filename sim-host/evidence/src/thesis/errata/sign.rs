//! Erratum: the sign of the vibration velocity in the slip velocity.

use super::Erratum;
use crate::thesis::case::PLOTTED_RATIO;
use crate::thesis::case::{Case, TABLE_4_1};
use crate::thesis::claim::{Check, number};
use crate::thesis::self_excitation::first_and_last;
use crate::thesis::sweep;
use contact::{Sign, SolveError};

/// Length of the run, s: 200 periods, of which the second half is evaluated.
const RUN_S: f64 = 200.0 / 60e3;

/// Computes the contradictions about the sign and its consequence.
pub fn errata() -> Result<Vec<Erratum>, SolveError> {
    Ok(vec![sign()?, self_excitation()?])
}

fn sign() -> Result<Erratum, SolveError> {
    let run = |sign: Sign| {
        let mut problem = Case { sign, ..TABLE_4_1 }.at_ratio(PLOTTED_RATIO, RUN_S);
        problem.window_s.0 = 0.5 * RUN_S;
        let solution = sweep::solution(&problem)?;
        let totals = solution.tally.unwrap_or_default().totals;
        // -F is the force on the mass: its work on the oscillator is -F x', with x' = s (V - Vt).
        let given_j = -sign.factor() * (totals.friction_work_j - problem.sliding_m_per_s * totals.friction_n_s);
        Ok::<_, SolveError>((solution.ratios.friction, given_j))
    };
    let ((r_passive, passive_j), (r_literal, literal_j)) = (run(Sign::Passive)?, run(Sign::Literal)?);
    let numbers = vec![
        number("friction's work on the oscillator in 100 periods, passive [J]", passive_j),
        number("literal [J]", literal_j),
        number("r, passive", r_passive),
        number("r, literal", r_literal),
    ];
    Ok(Erratum {
        id: "sign",
        places: "4.14 with 4.16, against 4.2, 4.25 and 4.27",
        printed: "The slip velocity is Vt - x' in the integrated equations, Vt + x' in the energies and in the Coulomb model.",
        instead: "With -F on the mass, friction dissipates energy only for V = Vt + x'; as printed, it drives the oscillator.",
        evidence: Check::new("velocity ratio 0.5, periods 100 to 200 from rest", passive_j < 0.0 && literal_j > 0.0, numbers),
    })
}

fn self_excitation() -> Result<Erratum, SolveError> {
    let [passive, literal] = first_and_last()?;
    let numbers = vec![number("natural part, 190-200 ms over first 10 ms, passive", passive), number("literal", literal)];
    Ok(Erratum {
        id: "self-excitation",
        places: "4.2 and 4.3.1, against 4.15",
        printed: "Friction alone excites an oscillation.",
        instead: "Dahl friction (4.15) does not fall with speed, so an oscillation never grows with the passive sign. It \
                  grows with the literal sign, and with LuGre friction on a falling Stribeck curve, which 4.15 omits.",
        evidence: Check::new("no excitation, from x' = 0.0534 m/s at 0.0267 m/s", passive < 1.0 && literal > 1.0, numbers),
    })
}
