//! The answer that errors are measured against: a Taylor series of high order with located reversals.
//!
//! Every coefficient follows from those before it (the products by one Cauchy sum), so the series is exact but for its end. A second
//! method, by other hands, must agree to [`AGREEMENT`], or there is no reference.

use std::f64::consts::TAU;

use anyhow::ensure;

use crate::case::{Case, Scaled};
use crate::dop853_peer::Dop853Peer;
use crate::peer::{Outcome, Peer, Samples, Setting};

/// Coefficients of a series.
const TERMS: usize = 25;
/// Steps a period, apart from those that end at reversals.
const STEPS: u32 = 16;
/// Where a reversal is looked for within a step: twice between neighbours would be missed.
const PROBES: u32 = 8;
/// Largest difference between the two methods, in the mean and in friction over Fc at any quarter period.
const AGREEMENT: f64 = 1e-12;
/// Tolerance of the second method.
const SECOND_TOLERANCE: f64 = 1e-14;

/// The reference of a case.
pub struct Reference {
    mean: f64,
    forces: Vec<f64>,
    largest: f64,
    /// How far the second method is from it: in the mean, and in friction over Fc.
    pub apart: (f64, f64),
}

impl Reference {
    /// Solves the case twice and compares.
    ///
    /// # Errors
    /// If the two differ by more than 1e-12.
    pub fn new(case: &Case) -> anyhow::Result<Self> {
        let Outcome { mean, forces, .. } = taylor(case);
        let largest = forces.iter().fold(0.0f64, |largest, force| largest.max(force.abs()));
        let mut reference = Reference { mean, forces, largest, apart: (0.0, 0.0) };
        let second = Dop853Peer::AutonomousEvents.run(case, Setting::Tolerance(SECOND_TOLERANCE))?;
        reference.apart = reference.errors(&second);
        let (mean, force) = reference.apart;
        ensure!(
            mean < AGREEMENT && force < AGREEMENT,
            "no reference: two methods differ by {mean:.1e} in the mean, {force:.1e} in F"
        );
        Ok(reference)
    }

    /// The mean friction ratio.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Error of an outcome's mean, absolute, and of its friction at quarter periods, the largest over the largest friction.
    pub fn errors(&self, outcome: &Outcome) -> (f64, f64) {
        let all = outcome.forces.iter().zip(&self.forces).map(|(force, exact)| (force - exact).abs());
        let force =
            if outcome.forces.len() == self.forces.len() { all.fold(0.0, f64::max) / self.largest } else { f64::INFINITY };
        ((outcome.mean - self.mean).abs(), force)
    }
}

/// x, v, f, q as series about a moment.
struct Series([[f64; TERMS]; 4]);

impl Series {
    fn new(scaled: &Scaled, sign: f64, phase: f64, y: &[f64; 4]) -> Self {
        let mut series = [[0.0; TERMS]; 4];
        let [x, v, f, q] = &mut series;
        (x[0], v[0], f[0], q[0]) = (y[0], y[1], y[2], y[3]);
        let (sine, cosine) = phase.sin_cos();
        // Term k of the cosine: its k-th derivative over k!.
        let derivatives = [cosine, -sine, -cosine, sine];
        let mut over_factorial = 1.0;
        for k in 0..TERMS - 1 {
            let per = 1.0 / (k + 1) as f64;
            let slip = |j: usize| if j == 0 { scaled.sliding + v[0] } else { v[j] };
            let product: f64 = (0..=k).map(|j| slip(j) * f[k - j]).sum();
            let forcing = scaled.forcing * derivatives[k % 4] * over_factorial;
            (x[k + 1], q[k + 1]) = (v[k] * per, scaled.share * f[k] * per);
            f[k + 1] = scaled.kappa * (slip(k) - sign * product) * per;
            v[k + 1] = (forcing - scaled.spring * x[k] - scaled.friction * f[k]) * per;
            over_factorial *= per;
        }
        Series(series)
    }

    fn at(&self, t: f64) -> [f64; 4] {
        self.0.map(|series| series.iter().rev().fold(0.0, |sum, term| sum * t + term))
    }

    /// First reversal within a length. At a reversal the slip is zero, and what is looked for is the next: a zero of slip over time.
    fn reversal(&self, sliding: f64, sign: f64, length: f64) -> Option<f64> {
        let mut slip = self.0[1];
        slip[0] += sliding;
        let terms = if slip[0] == 0.0 { &slip[1..] } else { &slip[..] };
        let forward = |t: f64| sign * terms.iter().rev().fold(0.0, |sum, term| sum * t + term);
        let probe = |number: u32| length * f64::from(number) / f64::from(PROBES);
        let after = (1..=PROBES).find(|&number| forward(probe(number)) < 0.0)?;
        let (mut before, mut after) = (probe(after - 1), probe(after));
        loop {
            let half = 0.5 * (before + after);
            if half <= before || half >= after {
                return Some(after);
            }
            if forward(half) < 0.0 { after = half } else { before = half }
        }
    }
}

/// The case by Taylor series.
fn taylor(case: &Case) -> Outcome {
    let scaled = &case.scaled;
    let mut samples = Samples::new(case);
    let (mut y, mut sign) = ([0.0; 4], 1.0);
    let step = TAU / f64::from(STEPS);
    for number in (0..case.periods).flat_map(|_| 0..STEPS) {
        let (mut phase, end) = (step * f64::from(number), step * f64::from(number + 1));
        while phase < end {
            let series = Series::new(scaled, sign, phase, &y);
            match series.reversal(scaled.sliding, sign, end - phase) {
                Some(at) => {
                    y = series.at(at);
                    (y[1], sign) = (-scaled.sliding, -sign);
                    phase += at;
                }
                None => {
                    y = series.at(end - phase);
                    phase = end;
                }
            }
        }
        if (number + 1) % (STEPS / 4) == 0 {
            samples.push(&y);
        }
    }
    samples.outcome(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_obeys_the_equations() {
        let scaled = Case::new(10).scaled;
        let (y, phase, sign) = ([0.3, 0.2, 0.4, 0.1], 0.7, 1.0);
        let series = Series::new(&scaled, sign, phase, &y);
        let (t, h) = (0.2, 1e-3);
        let [ahead, behind, now] = [t + h, t - h, t].map(|t| series.at(t));
        let mut rates = [0.0; 4];
        scaled.held(sign, (phase + t).cos(), &now, &mut rates);
        for i in 0..4 {
            // h^2 / 6 times a third derivative of order one.
            assert!(((ahead[i] - behind[i]) / (2.0 * h) - rates[i]).abs() < 1e-6, "{i}");
        }
    }

    #[test]
    fn two_methods_agree() {
        let reference = Reference::new(&Case::new(100)).unwrap();
        assert!(reference.apart.0 < 1e-14 && reference.apart.1 < 1e-13, "{:?}", reference.apart);
    }

    #[test]
    fn errors_are_those_of_the_outcome() {
        let case = Case::new(4);
        let reference = Reference::new(&case).unwrap();
        let mut outcome = taylor(&case);
        assert_eq!(reference.errors(&outcome), (0.0, 0.0));
        outcome.mean += 1e-3;
        outcome.forces[7] -= 1e-2 * reference.largest;
        let (mean, force) = reference.errors(&outcome);
        assert!((mean - 1e-3).abs() < 1e-15 && (force - 1e-2).abs() < 1e-15);
        outcome.forces.pop();
        assert_eq!(reference.errors(&outcome).1, f64::INFINITY);
    }
}
