//! Continuous wavelet transform with Morlet's wavelet (Grossmann and Morlet 1984; Torrence and
//! Compo 1998, Bull. Amer. Meteor. Soc. 79).
//!
//! ```text
//! W(t, f) = integral X(nu) 2 exp(-(c (nu - f) / f)^2 / 2) exp(2 pi i nu t) dnu,    nu > 0
//! ```
//!
//! `X` is the signal's transform and `c` the wavelet's angular centre frequency; a wavelet has
//! about `c / 2 pi` cycles. It blurs a frequency by the fraction `1 / c` (standard deviation) and a
//! time by `c / (2 pi f)`. Low frequencies are well resolved in frequency, high ones in time; a
//! window of the short-time transform has the same length for all. A sine of amplitude `a` has a
//! peak of `|W|^2 / 2 = a^2 / 2`.
//!
//! The same number of zeros is appended to the signal, so that its end does not affect its
//! beginning. Within `sqrt(2) c / (2 pi f)` of either end (the cone of influence) the result is too
//! small.

use realfft::num_complex::Complex;
use rustfft::FftPlanner;

/// Power over time and over frequencies of equal ratios.
#[derive(Clone, Debug, PartialEq)]
pub struct Scalogram {
    /// Time of the first column, s from the first sample.
    pub first_s: f64,
    /// Time from column to column, s.
    pub every_s: f64,
    /// Frequencies of the rows, Hz, rising.
    pub hz: Vec<f64>,
    /// Power by time, then by frequency.
    pub columns: Vec<Vec<f64>>,
}

/// Morlet's wavelet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Morlet {
    /// Angular centre frequency `c`, in units of the scale; at 5 or more the wavelet's mean is
    /// negligible.
    pub centre: f64,
}

impl Default for Morlet {
    /// Returns six, as used by Torrence and Compo.
    fn default() -> Self {
        Morlet { centre: 6.0 }
    }
}

/// Returns the power of real samples at these frequencies, Hz, with a column every `hop` samples.
pub fn wavelet(samples: &[f64], sample_s: f64, morlet: Morlet, hz: &[f64], hop: usize) -> Scalogram {
    let hop = hop.max(1);
    let length = (2 * samples.len()).next_power_of_two().max(2);
    let mut planner = FftPlanner::new();
    let (forward, inverse) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
    let mut spectrum: Vec<Complex<f64>> = samples.iter().map(|&sample| Complex::new(sample, 0.0)).collect();
    spectrum.resize(length, Complex::new(0.0, 0.0));
    forward.process(&mut spectrum);
    let bin_hz = 1.0 / (length as f64 * sample_s);
    let mut columns = vec![Vec::with_capacity(hz.len()); samples.len().div_ceil(hop)];
    let mut row = vec![Complex::new(0.0, 0.0); length];
    for &centre_hz in hz {
        row.fill(Complex::new(0.0, 0.0));
        for (bin, value) in spectrum.iter().enumerate().take(length / 2).skip(1) {
            let off = morlet.centre * (bin as f64 * bin_hz / centre_hz - 1.0);
            row[bin] = value * (2.0 * (-0.5 * off * off).exp() / length as f64);
        }
        inverse.process(&mut row);
        for (column, value) in columns.iter_mut().zip(row.iter().step_by(hop)) {
            column.push(0.5 * value.norm_sqr());
        }
    }
    Scalogram { first_s: 0.0, every_s: hop as f64 * sample_s, hz: hz.to_vec(), columns }
}

/// Returns `rows` frequencies of equal ratios including both ends, Hz.
pub fn ratios(from_hz: f64, to_hz: f64, rows: usize) -> Vec<f64> {
    let steps = rows.saturating_sub(1).max(1) as f64;
    (0..rows).map(|row| from_hz * (to_hz / from_hz).powf(row as f64 / steps)).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const SAMPLE_S: f64 = 1e-5;

    fn tone(hz: f64, amplitude: f64) -> Vec<f64> {
        (0..4096).map(|n| amplitude * (TAU * hz * f64::from(n) * SAMPLE_S).sin()).collect()
    }

    #[test]
    fn a_sine_has_its_power_and_the_wavelets_width() {
        let hz = [4000.0 * (1.0 - 1.0 / 6.0), 4000.0, 4000.0 * 1.25];
        let map = wavelet(&tone(4000.0, 0.7), SAMPLE_S, Morlet::default(), &hz, 16);
        let middle = &map.columns[map.columns.len() / 2];
        assert!((middle[1] / 0.245 - 1.0).abs() < 1e-6, "{}", middle[1]);
        // exp(-x^2), with x the distance over the row's frequency times six.
        for (row, power) in [(0, hz[0]), (2, hz[2])] {
            let x = 6.0 * (4000.0 / power - 1.0);
            assert!((middle[row] / (0.245 * (-x * x).exp()) - 1.0).abs() < 1e-3, "{row}: {}", middle[row]);
        }
    }

    #[test]
    fn the_ridge_of_a_chirp_is_its_frequency() {
        // From 2 to 20 kHz by equal ratios in 41 ms.
        let (from, rate): (f64, f64) = (2e3, 10f64.ln() / (4096.0 * SAMPLE_S));
        let samples: Vec<f64> =
            (0..4096).map(|n| (TAU * from / rate * ((rate * f64::from(n) * SAMPLE_S).exp() - 1.0)).sin()).collect();
        let hz = ratios(1e3, 40e3, 200);
        let map = wavelet(&samples, SAMPLE_S, Morlet { centre: 12.0 }, &hz, 64);
        for (column, powers) in map.columns.iter().enumerate().skip(8).take(48) {
            let row = powers.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(row, _)| row);
            let truth = from * (rate * map.every_s * column as f64).exp();
            assert!((hz[row] / truth - 1.0).abs() < 0.02, "{column}: {} {truth}", hz[row]);
        }
    }

    #[test]
    fn the_end_does_not_reach_the_beginning() {
        let mut samples = vec![0.0; 4000];
        samples[3990..].fill(1.0);
        let map = wavelet(&samples, SAMPLE_S, Morlet::default(), &[4000.0], 1);
        assert!(map.columns[..1000].iter().all(|column| column[0] < 1e-12));
        assert!(map.columns[3990][0] > 1e-3);
    }

    #[test]
    fn frequencies_have_equal_ratios_and_both_ends() {
        let hz = ratios(10.0, 1000.0, 5);
        assert_eq!((hz[0], hz.len()), (10.0, 5));
        assert!((hz[4] - 1000.0).abs() < 1e-9 && (hz[2] - 100.0).abs() < 1e-9);
    }
}
