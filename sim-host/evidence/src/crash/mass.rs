//! Estimates the mass from the crash itself: the best quadratic function of force and payout up to
//! a moment, by least squares over many passive crashes.
//!
//! ```text
//! R2 = 1 - sum of squared residuals / sum of squares about the mean
//! ```
//!
//! The function is fitted to the same crashes that it is judged by, so no function of this form can
//! do better. Drawn at random: mass 14 to 29 kg; pulse, stiffness and slack as in the suite.

use rayon::prelude::*;

use super::{plant, scheduled};
use crate::evidence::Error;
use crate::random::Random;
use plant::dring::motion::Motion;
use plant::dring::pulse::Course;
use plant::dring::{Bench, G_M_PER_S2};

/// Moments of the estimates, ms after the beginning of the crash.
const AT_MS: [f64; 6] = [30.0, 40.0, 50.0, 60.0, 80.0, 100.0];
/// Range of the masses, kg.
const MASS_KG: (f64, f64) = (14.0, 29.0);
/// Range of the peak of the pulse, g, as in the suite.
const PULSE_G: (f64, f64) = (15.0, 25.0);
/// Range of the stiffness of the shoulder belt, as in the suite.
const STIFFNESS_N_PER_M: (f64, f64) = (40e3, 120e3);
/// Range of the slack, as in the suite.
const SLACK_M: (f64, f64) = (0.0, 0.03);
/// Range of the relative error of the seat, as in the suite.
const SEAT_ERROR: (f64, f64) = (-0.15, 0.15);
/// Number of signals at a moment: force, payout, their rates, and the sum of the force so far.
const SIGNALS: usize = 5;
/// Number of terms of a quadratic function of all signals.
const TERMS: usize = 1 + SIGNALS + SIGNALS * (SIGNALS + 1) / 2;

/// Quality of an estimate of the mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Time of the estimate, ms; `None` for the reading of the seat.
    pub at_ms: Option<f64>,
    /// Fraction of the variance that is explained.
    pub r2: f64,
    /// Standard deviation of the residuals, kg.
    pub residual_kg: f64,
}

/// Draws and runs `crashes` crashes, and returns the estimates.
pub fn run(crashes: u32) -> Result<Vec<Estimate>, Error> {
    let base = plant(&[])?.0.passive();
    let mut random = Random::new(1);
    let mut between = |(from, to): (f64, f64)| random.between(from, to);
    let drawn: Vec<(Bench, f64)> = (0..crashes)
        .map(|_| {
            let mut bench = base.clone();
            bench.torso_kg = between(MASS_KG);
            bench.pulse.course = Course::HalfSine(G_M_PER_S2 * between(PULSE_G));
            bench.shoulder.stiffness_n_per_m = between(STIFFNESS_N_PER_M);
            bench.shoulder.slack_m = between(SLACK_M);
            let reading = bench.torso_kg * (1.0 + between(SEAT_ERROR));
            (bench, reading)
        })
        .collect();
    let masses: Vec<f64> = drawn.iter().map(|(bench, _)| bench.torso_kg).collect();
    let seen: Vec<Vec<[f64; SIGNALS]>> = drawn.par_iter().map(|(bench, _)| signals(bench)).collect();
    let mut known: Vec<Estimate> = AT_MS
        .iter()
        .enumerate()
        .map(|(n, &ms)| estimate(Some(ms), &masses, &seen.iter().map(|seen| seen[n].to_vec()).collect::<Vec<_>>()))
        .collect();
    known.push(estimate(None, &masses, &drawn.iter().map(|(_, reading)| vec![*reading]).collect::<Vec<_>>()));
    Ok(known)
}

/// Returns the signals of a crash at each moment.
fn signals(bench: &Bench) -> Vec<[f64; SIGNALS]> {
    const BEFORE_MS: f64 = 2.0;
    let mut playback: Vec<(f64, f64, f64, f64)> = Vec::new();
    let mut impulse = 0.0;
    let see = |since_s: f64, motion: &Motion| {
        let force = motion.tensions().shoulder_n;
        impulse += force;
        playback.push((1e3 * since_s, force, motion.state().payout_m, impulse));
    };
    let last_s = 1e-3 * AT_MS.iter().copied().fold(0.0, f64::max);
    scheduled::crash(bench, 1.0, last_s, |_| false, see);
    let at = |ms: f64| playback.iter().rfind(|seen| seen.0 <= ms + 1e-9).copied().unwrap_or_default();
    let one = |&ms: &f64| {
        let (now, before) = (at(ms), at(ms - BEFORE_MS));
        [now.1, 1e6 * now.2, now.1 - before.1, 1e6 * (now.2 - before.2), now.3]
    };
    AT_MS.iter().map(one).collect()
}

/// Fits a quadratic function of the signals to the masses.
fn estimate(at_ms: Option<f64>, masses: &[f64], seen: &[Vec<f64>]) -> Estimate {
    let count = masses.len() as f64;
    let signals = seen.first().map_or(0, Vec::len);
    // Scaled to mean zero and deviation one, so that squares stay comparable.
    let scaled: Vec<Vec<f64>> = (0..signals)
        .map(|signal| {
            let mean = seen.iter().map(|one| one[signal]).sum::<f64>() / count;
            let deviation = (seen.iter().map(|one| (one[signal] - mean).powi(2)).sum::<f64>() / count).sqrt();
            seen.iter().map(|one| if deviation > 0.0 { (one[signal] - mean) / deviation } else { 0.0 }).collect()
        })
        .collect();
    let terms = |n: usize| {
        let mut terms = vec![1.0];
        for i in 0..signals {
            terms.push(scaled[i][n]);
            terms.extend((i..signals).map(|j| scaled[i][n] * scaled[j][n]));
        }
        terms
    };
    let rows: Vec<Vec<f64>> = (0..masses.len()).map(terms).collect();
    let left = residual(&rows, masses);
    let mean = masses.iter().sum::<f64>() / count;
    let all: f64 = masses.iter().map(|mass| (mass - mean).powi(2)).sum();
    Estimate { at_ms, r2: 1.0 - left / all, residual_kg: (left / count).sqrt() }
}

/// Returns the sum of squared residuals of the best linear combination of the rows' terms. Each
/// term is made orthogonal to those before it (Gram and Schmidt, in the modified order), and its
/// part is subtracted from the values.
fn residual(rows: &[Vec<f64>], values: &[f64]) -> f64 {
    /// Relative square below which a term is a combination of the earlier ones, and is left out.
    const DEPENDENT_REL: f64 = 1e-9;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let terms = rows.first().map_or(0, Vec::len).min(TERMS);
    let mut left = values.to_vec();
    let mut orthogonal: Vec<Vec<f64>> = Vec::new();
    for term in 0..terms {
        let mut column: Vec<f64> = rows.iter().map(|row| row[term]).collect();
        let own = dot(&column, &column);
        for earlier in &orthogonal {
            let part = dot(&column, earlier);
            column.iter_mut().zip(earlier).for_each(|(value, earlier)| *value -= part * earlier);
        }
        let square = dot(&column, &column);
        if square <= DEPENDENT_REL * own {
            continue;
        }
        let norm = square.sqrt();
        column.iter_mut().for_each(|value| *value /= norm);
        let part = dot(&left, &column);
        left.iter_mut().zip(&column).for_each(|(value, column)| *value -= part * column);
        orthogonal.push(column);
    }
    dot(&left, &left)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_mass_dependence_is_recognised() {
        let seen: Vec<Vec<f64>> = (0..200).map(|n| vec![f64::from(n % 17), f64::from(n % 23)]).collect();
        let masses: Vec<f64> = seen.iter().map(|s| 3.0 + s[0] - 0.1 * s[0] * s[1] + 0.2 * s[1] * s[1]).collect();
        assert!((estimate(None, &masses, &seen).r2 - 1.0).abs() < 1e-12);
        let apart: Vec<f64> = (0..200).map(|n| f64::from((n * n * 7919) % 211)).collect();
        assert!(estimate(None, &apart, &seen).r2 < 0.1);
    }
}
