//! Interpolation between samples of a signal without content near half the sample rate.
//!
//! ```text
//! x(t) = sum_n x(n) sinc(t - n) w((t - n) / H),    w(u) = cos(pi u / 2)^2,    |t - n| < H
//! ```
//!
//! Shannon's series, limited to `H` samples to either side by a Hann window, with weights of sum
//! one. Beyond the ends the signal is extended with point symmetry about its first and its last
//! sample, which keeps its slope. A sample that is NaN divides the signal into two.

use std::f64::consts::PI;

/// Number of samples to either side.
const HALF_WIDTH: i64 = 8;

/// Returns the samples with `parts - 1` values between any two of them; the samples themselves are
/// unchanged.
pub(super) fn between(samples: &[f64], parts: usize) -> Vec<f64> {
    let mut all = Vec::with_capacity(samples.len() * parts);
    let mut runs = samples.chunk_by(|a, b| a.is_finite() == b.is_finite()).peekable();
    while let Some(run) = runs.next() {
        for (n, &sample) in run.iter().enumerate() {
            all.push(sample);
            let last = n + 1 == run.len();
            if !last || runs.peek().is_some() {
                let value = |part| if last { f64::NAN } else { at(run, n as i64, part as f64 / parts as f64) };
                all.extend((1..parts).map(value));
            }
        }
    }
    all
}

/// Returns the value at a fraction of a step after sample `n`.
fn at(samples: &[f64], n: i64, part: f64) -> f64 {
    let weight = |m: i64| {
        let distance = part - m as f64;
        (PI * distance).sin() / (PI * distance) * (0.5 * PI * distance / HALF_WIDTH as f64).cos().powi(2)
    };
    let (sum, weights) = (1 - HALF_WIDTH..=HALF_WIDTH).fold((0.0, 0.0), |(sum, weights), m| {
        let weight = weight(m);
        (sum + weight * extended(samples, n + m), weights + weight)
    });
    sum / weights
}

/// Returns a sample, or its extension beyond the ends.
fn extended(samples: &[f64], n: i64) -> f64 {
    let last = samples.len() as i64 - 1;
    let inside = |n: i64| samples[n.clamp(0, last) as usize];
    if n < 0 {
        2.0 * samples[0] - inside(-n)
    } else if n > last {
        2.0 * samples[last as usize] - inside(2 * last - n)
    } else {
        inside(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the largest errors between samples for 100 samples of a tone of `period` samples:
    /// within, and near the ends.
    fn errors(period: f64) -> (f64, f64) {
        let tone = |t: f64| (2.0 * PI * t / period + 0.3).sin();
        let samples: Vec<f64> = (0..100).map(|n| tone(f64::from(n))).collect();
        let filled = between(&samples, 8);
        assert_eq!(filled.len(), 99 * 8 + 1);
        let off = filled.iter().enumerate().map(|(n, value)| (n, (value - tone(n as f64 / 8.0)).abs()));
        off.fold(
            (0.0, 0.0),
            |(inside, ends): (f64, f64), (n, off)| {
                if (64..=99 * 8 - 64).contains(&n) { (inside.max(off), ends) } else { (inside, ends.max(off)) }
            },
        )
    }

    #[test]
    fn a_tone_is_reconstructed() {
        // Straight lines have errors of 5e-3 with 32 samples a period, and 8e-2 with 8.
        let (inside, ends) = errors(32.0);
        assert!(inside < 5e-4 && ends < 5e-3, "{inside:e} {ends:e}");
        let (inside, _) = errors(8.0);
        assert!(inside < 2e-3, "{inside:e}");
    }

    #[test]
    fn samples_stay_and_gaps_stay_gaps() {
        let samples = [0.0, 1.0, f64::NAN, 3.0, 2.0];
        let filled = between(&samples, 2);
        assert_eq!((filled.len(), filled[0], filled[2], filled[6], filled[8]), (9, 0.0, 1.0, 3.0, 2.0));
        assert!(filled[3..6].iter().all(|value| value.is_nan()));
        assert_eq!(between(&[5.0], 8), [5.0]);
        assert!(between(&[], 8).is_empty());
    }

    #[test]
    fn a_straight_line_stays_one() {
        let line: Vec<f64> = (0..20).map(f64::from).collect();
        let off = between(&line, 4).iter().enumerate().map(|(n, y)| (y - n as f64 / 4.0).abs()).fold(0.0, f64::max);
        assert!(off < 1e-2, "{off}");
    }
}
