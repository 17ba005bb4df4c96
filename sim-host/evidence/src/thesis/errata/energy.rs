//! The energy balance.

use super::Erratum;
use crate::thesis::case::PLOTTED_RATIO;
use crate::thesis::case::{SHORT_S, TABLE_4_1};
use crate::thesis::claim::{Check, number};
use crate::thesis::sweep;
use contact::SolveError;

/// Computes the contradictions of the energy balance and its dimensions.
pub fn errata() -> Result<Vec<Erratum>, SolveError> {
    Ok(vec![balance()?, dimensions()?, sliding_work()?])
}

fn balance() -> Result<Erratum, SolveError> {
    let ratios = sweep::ratios(&TABLE_4_1.at_ratio(PLOTTED_RATIO, SHORT_S))?;
    let [power, input, stored, printed] =
        [ratios.power, ratios.input, ratios.stored, ratios.power_as_printed].map(|value| value.unwrap_or(f64::NAN));
    let identity = ratios.friction + input - stored;
    let numbers = vec![
        number("phi = mean(F V)/(Fc Vt)", power),
        number("phi by 4.35", printed),
        number("r + phi_iu - dE/(Fc Vt T)", identity),
        number("r", ratios.friction),
        number("phi_iu", input),
        number("dE/(Fc Vt T)", stored),
    ];
    Ok(Erratum {
        id: "energy-balance",
        places: "4.23, 4.28, 4.33, 4.35",
        printed: "phi_ru = 1 + phi_iu - phi_su.",
        instead: "phi_ru = r + phi_iu - dE/(Fc Vt T): the sliding drive does the work r Fc Vt T, and the gain of stored \
                  energy counts, not its mean.",
        evidence: Check::new(
            "velocity ratio 0.5, first ms from rest",
            (identity - power).abs() < 1e-4 && (printed - power).abs() > 1.0,
            numbers,
        ),
    })
}

fn dimensions() -> Result<Erratum, SolveError> {
    let durations = [1.0, 2.0, 5.0, 10.0].map(|count| count * SHORT_S);
    let ratios = sweep::each(&durations, |&duration_s| sweep::ratios(&TABLE_4_1.at_ratio(PLOTTED_RATIO, duration_s)))?;
    let mut numbers = Vec::new();
    for (duration_s, ratios) in durations.iter().zip(&ratios) {
        let ms = 1e3 * duration_s;
        numbers.push(number(format!("by 4.35, first {ms} ms"), ratios.power_as_printed.unwrap_or(f64::NAN)));
        numbers.push(number(format!("direct, first {ms} ms"), ratios.power.unwrap_or(f64::NAN)));
    }
    let spread = |values: Vec<f64>| {
        let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
        high - low
    };
    let direct = spread(ratios.iter().filter_map(|ratios| ratios.power).collect());
    let printed = spread(ratios.iter().filter_map(|ratios| ratios.power_as_printed).collect());
    Ok(Erratum {
        id: "energy-mean-and-work",
        places: "4.25, 4.26, 4.30, against 4.24, 4.27",
        printed: "Mean energies, in J, are subtracted from works over T, in J.",
        instead: "Work grows with T and a mean energy does not: phi_su, and phi_ru by 4.35, depend on the duration.",
        evidence: Check::new("velocity ratio 0.5, from rest", printed > 100.0 * direct, numbers),
    })
}

fn sliding_work() -> Result<Erratum, SolveError> {
    let ratios = sweep::ratios(&TABLE_4_1.at_ratio(PLOTTED_RATIO, SHORT_S))?;
    let sliding_m_per_s = PLOTTED_RATIO * TABLE_4_1.vibration_m_per_s();
    let kinetic_j = 0.5 * TABLE_4_1.mass_kg * sliding_m_per_s * sliding_m_per_s;
    let friction_j = TABLE_4_1.coulomb_n() * sliding_m_per_s * SHORT_S;
    let numbers = vec![
        number("friction against the sliding, over Fn", ratios.friction),
        number("m Vt^2/2 over Fn Vt T, T = 1 ms", kinetic_j / friction_j),
        number("T = 10 ms", 0.1 * kinetic_j / friction_j),
    ];
    Ok(Erratum {
        id: "energy-sliding-work",
        places: "4.23, 4.24, 4.28",
        printed: "With ultrasonics the sliding still needs Fn Vt T, and also m Vt^2/2 in every T.",
        instead: "With ultrasonics it needs r Fn Vt T; a constant speed needs no kinetic energy.",
        evidence: Check::new(
            "velocity ratio 0.5, first ms from rest",
            ratios.friction < 0.99 && kinetic_j > 0.01 * friction_j,
            numbers,
        ),
    })
}
