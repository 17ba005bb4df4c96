//! Wigner-Ville distribution (Ville 1948) of the analytic signal `z`, smoothed or not.
//!
//! ```text
//! W(n, k) = sum_m h(m) sum_p g(p) z(n + p + m) z*(n + p - m) exp(-2 pi i k m / R),    frequency k fs / (2 R)
//! ```
//!
//! `m` runs over the lags, `|m| < R / 2` and within `h`, with `R` rows; `z` is zero outside. With
//! `h = 1` over all lags and no `g` it is the plain distribution; with a window `h` of lags,
//! pseudo; with a window `g` of times as well, smoothed pseudo (Flandrin and Martin 1984).
//!
//! Exact properties: the mean over the rows is `sum_p g(p) |z(n + p)|^2` (the time marginal),
//! because the sum over all rows leaves only lag zero. With a `g` of sum one, the mean over rows
//! and sum over times is therefore the signal's energy. Without windows, and for a signal that
//! fades within its samples, the sum over times is `|Z(f)|^2` (the frequency marginal).
//!
//! Two components at `f1` and `f2` have a third term halfway, which oscillates over time at
//! `|f1 - f2|` about zero. A window of times that spans several of its periods removes it, and
//! blurs time by as much; the window of lags blurs frequency.

use std::f64::consts::TAU;

use realfft::num_complex::Complex;
use rustfft::FftPlanner;

use super::{Map, analytic};

/// Smoothing and resolution of the distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing {
    /// Number of rows, from zero to half the sample rate.
    pub rows: usize,
    /// Half the length of the Hann window of lags, samples; with `None` all lags within the rows
    /// have the same weight.
    pub lags: Option<usize>,
    /// Length of the Hann window of times, samples; no window if at most one.
    pub times: usize,
    /// Step from column to column, samples.
    pub hop: usize,
}

/// Returns the distribution of real samples. A component of amplitude `a` contributes `a^2` to the
/// mean over the rows.
pub fn wigner_ville(samples: &[f64], sample_s: f64, smoothing: Smoothing) -> Map {
    let z = analytic(samples);
    let rows = smoothing.rows.max(1);
    let lags = lag_weights(rows.div_ceil(2), smoothing.lags);
    let times = time_weights(smoothing.times);
    let transform = FftPlanner::new().plan_fft_forward(rows);
    let hop = smoothing.hop.max(1);
    let column = |n: usize| {
        let mut products = vec![Complex::new(0.0, 0.0); rows];
        for (m, &weight) in lags.iter().enumerate() {
            let product = times.iter().map(|&(p, g)| lagged(&z, n as i64 + p, m as i64) * g).sum::<Complex<f64>>() * weight;
            products[m] = product;
            if m > 0 {
                // Later plus earlier: the distribution is real.
                products[rows - m] = product.conj();
            }
        }
        transform.process(&mut products);
        products.into_iter().map(|value| value.re).collect()
    };
    Map {
        first_s: 0.0,
        every_s: hop as f64 * sample_s,
        bin_hz: 0.5 / (rows as f64 * sample_s),
        columns: (0..z.len()).step_by(hop).map(column).collect(),
    }
}

/// Returns `z(n + m) z*(n - m)`, zero outside.
fn lagged(z: &[Complex<f64>], n: i64, m: i64) -> Complex<f64> {
    let at = |index: i64| usize::try_from(index).ok().and_then(|index| z.get(index));
    at(n + m).zip(at(n - m)).map_or(Complex::new(0.0, 0.0), |(later, earlier)| later * earlier.conj())
}

/// Returns the weights of at most `most` lags, from zero on.
fn lag_weights(most: usize, window: Option<usize>) -> Vec<f64> {
    match window {
        None => vec![1.0; most],
        Some(half) => (0..most.min(half.max(1))).map(|m| 0.5 + 0.5 * (0.5 * TAU * m as f64 / half as f64).cos()).collect(),
    }
}

/// Returns offsets and weights of the times, with a sum of one.
fn time_weights(length: usize) -> Vec<(i64, f64)> {
    let half = (length.max(1) / 2) as i64;
    let hann = |p: i64| 0.5 + 0.5 * (TAU * p as f64 / (2 * half + 2) as f64).cos();
    let sum: f64 = (-half..=half).map(hann).sum();
    (-half..=half).map(|p| (p, hann(p) / sum)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE_S: f64 = 1e-6;
    const PLAIN: Smoothing = Smoothing { rows: 1024, lags: None, times: 1, hop: 1 };

    /// Returns tones in one Gaussian envelope, which fades to 1e-14 within the samples.
    fn tones(count: usize, hz: &[f64]) -> Vec<f64> {
        let sigma = count as f64 / 16.0;
        let sample = |n: usize| {
            let t = n as f64 - 0.5 * count as f64;
            (-0.5 * (t / sigma).powi(2)).exp() * hz.iter().map(|hz| (TAU * hz * n as f64 * SAMPLE_S).cos()).sum::<f64>()
        };
        (0..count).map(sample).collect()
    }

    fn energy(z: &[Complex<f64>]) -> f64 {
        z.iter().map(Complex::norm_sqr).sum()
    }

    #[test]
    fn the_ridge_of_a_chirp_is_its_frequency() {
        let rate = 100e3 / 1e-3;
        let samples: Vec<f64> = (0..1000)
            .map(|n| {
                let t = f64::from(n) * SAMPLE_S;
                (TAU * (50e3 * t + 0.5 * rate * t * t)).cos()
            })
            .collect();
        for smoothing in [PLAIN, Smoothing { rows: 256, lags: Some(128), times: 9, hop: 4 }] {
            let map = wigner_ville(&samples, SAMPLE_S, smoothing);
            // At the ends a window of lags has no samples.
            for (column, hz) in map.ridge_hz().into_iter().enumerate() {
                let t = map.time_s(column);
                if (100e-6..900e-6).contains(&t) {
                    let off = hz - (50e3 + rate * t);
                    assert!(off.abs() <= map.bin_hz, "{t}: {off} Hz, a bin is {} Hz", map.bin_hz);
                }
            }
        }
    }

    /// To round-off, the mean over the rows is the power at that time, smoothed or not, for any
    /// window of lags.
    #[test]
    fn time_marginal_and_energy_are_exact() {
        let samples = tones(600, &[40e3, 130e3]);
        let z = analytic(&samples);
        for smoothing in [PLAIN, Smoothing { rows: 128, lags: Some(40), ..PLAIN }, Smoothing { rows: 255, ..PLAIN }] {
            let map = wigner_ville(&samples, SAMPLE_S, smoothing);
            let means: Vec<f64> = map.columns.iter().map(|column| column.iter().sum::<f64>() / column.len() as f64).collect();
            let worst = means.iter().zip(&z).map(|(mean, z)| (mean - z.norm_sqr()).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-13, "{worst} with {smoothing:?}");
            assert!((means.iter().sum::<f64>() / energy(&z) - 1.0).abs() < 1e-13);
        }
        // Smoothed over time, each power is the mean of its neighbours', so the sum is unchanged.
        let smoothed = wigner_ville(&samples, SAMPLE_S, Smoothing { times: 33, lags: Some(128), rows: 256, hop: 1 });
        let sum: f64 = smoothed.columns.iter().map(|column| column.iter().sum::<f64>() / column.len() as f64).sum();
        assert!((sum / energy(&z) - 1.0).abs() < 1e-12, "{sum}");
    }

    #[test]
    fn the_frequency_marginal_is_the_spectrum() {
        let samples = tones(512, &[110e3]);
        let map = wigner_ville(&samples, SAMPLE_S, PLAIN);
        let z = analytic(&samples);
        for bin in (150..300).step_by(7) {
            let hz = bin as f64 * map.bin_hz;
            let marginal: f64 = map.columns.iter().map(|column| column[bin]).sum();
            let spectrum: Complex<f64> =
                z.iter().enumerate().map(|(n, z)| z * Complex::from_polar(1.0, -TAU * hz * n as f64 * SAMPLE_S)).sum();
            // Only pairs of samples an even distance apart contribute: half of all.
            let expected = 0.5 * spectrum.norm_sqr();
            assert!((marginal - expected).abs() < 1e-9 * energy(&z), "{hz}: {marginal} {expected}");
        }
    }

    /// Halfway between two tones is a third term, twice as high as either; smoothed over some of
    /// its periods it falls to the window's side lobe.
    #[test]
    fn smoothing_removes_the_cross_term() {
        let samples: Vec<f64> =
            (0..2048).map(|n| [60e3, 140e3].map(|hz| (TAU * hz * f64::from(n) * SAMPLE_S).cos()).iter().sum()).collect();
        let height = |smoothing: Smoothing, hz: f64| {
            let map = wigner_ville(&samples, SAMPLE_S, smoothing);
            let bin = (hz / map.bin_hz).round() as usize;
            let middle = &map.columns[map.columns.len() / 3..2 * map.columns.len() / 3];
            middle.iter().map(|column| column[bin].abs()).fold(0.0, f64::max)
        };
        let plain = Smoothing { rows: 500, lags: Some(250), times: 1, hop: 1 };
        let (tone, cross) = (height(plain, 60e3), height(plain, 100e3));
        assert!((cross / tone - 2.0).abs() < 1e-3, "{cross} {tone}");
        // Its period is 12.5 samples, and the transform of a Hann window at nu bins is sinc(nu) /
        // (1 - nu^2): here 53 dB down.
        let smoothed = Smoothing { times: 51, ..plain };
        let nu: f64 = 52.0 / 12.5;
        let side_lobe = (nu * TAU / 2.0).sin() / (nu * TAU / 2.0 * (1.0 - nu * nu));
        let left = height(smoothed, 100e3) / tone;
        assert!((left - 2.0 * side_lobe.abs()).abs() < 1e-4, "{left} {side_lobe}");
        assert!((height(smoothed, 60e3) / tone - 1.0).abs() < 1e-3);
    }
}
