//! Short-time Fourier transform: `X(n, f) = sum_m w(m) x(n + m) exp(-2 pi i f m)`, with a Hann
//! window `w`.
//!
//! A window of length `L` blurs a time by about `L / 2` samples and a frequency by about two bins
//! of `fs / L`. For a sweep of `c` Hz a second both are smallest at `L = fs / sqrt(c)`: in a longer
//! window the frequency changes noticeably, a shorter one does not resolve it.

use std::f64::consts::TAU;

use realfft::RealFftPlanner;

use super::Map;

/// Number of rows per resolved bin: zeros are appended to a window, which interpolates its
/// spectrum.
const ROWS_PER_BIN: usize = 2;

/// Returns the power of each frequency over time: a sine of amplitude `a` has a peak of `a^2 / 2`.
/// Windows of `window` samples begin every `hop` samples; the map is empty if there are fewer
/// samples than one window.
pub fn stft(samples: &[f64], sample_s: f64, window: usize, hop: usize) -> Map {
    let weights: Vec<f64> = (0..window).map(|n| 0.5 - 0.5 * (TAU * (n as f64 + 0.5) / window as f64).cos()).collect();
    let sum: f64 = weights.iter().sum();
    let length = ROWS_PER_BIN * window.max(1);
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let (mut windowed, mut bins) = (transform.make_input_vec(), transform.make_output_vec());
    let column = |start: usize| {
        windowed.fill(0.0);
        for (to, (sample, weight)) in windowed.iter_mut().zip(samples[start..start + window].iter().zip(&weights)) {
            *to = sample * weight;
        }
        let done = transform.process(&mut windowed, &mut bins).is_ok();
        bins.iter().map(|bin| if done { 2.0 * bin.norm_sqr() / (sum * sum) } else { f64::NAN }).collect()
    };
    let starts = (0..samples.len()).step_by(hop.max(1)).take_while(|start| window > 0 && start + window <= samples.len());
    Map {
        first_s: 0.5 * (window as f64 - 1.0) * sample_s,
        every_s: hop.max(1) as f64 * sample_s,
        bin_hz: 1.0 / (length as f64 * sample_s),
        columns: starts.map(column).collect(),
    }
}

/// Returns the even window length that blurs a linear sweep least, samples.
pub fn window_for(sweep_hz_per_s: f64, sample_s: f64) -> usize {
    let samples = 1.0 / (sweep_hz_per_s.abs().sqrt() * sample_s);
    // Twice the optimum of a rectangle: a Hann window emphasises its middle half.
    2 * (samples.round() as usize).clamp(8, 1 << 14)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE_S: f64 = 1e-6;

    /// Returns a linear chirp from 20 to 200 kHz in 5 ms.
    fn chirp() -> (Vec<f64>, impl Fn(f64) -> f64) {
        let rate = 180e3 / 5e-3;
        let samples = (0..5000).map(|n| {
            let t = f64::from(n) * SAMPLE_S;
            (TAU * (20e3 * t + 0.5 * rate * t * t)).sin()
        });
        (samples.collect(), move |t| 20e3 + rate * t)
    }

    #[test]
    fn the_ridge_of_a_chirp_is_its_frequency() {
        let (samples, frequency) = chirp();
        let window = window_for(180e3 / 5e-3, SAMPLE_S);
        let map = stft(&samples, SAMPLE_S, window, 16);
        assert!(map.columns.len() > 200);
        for (column, hz) in map.ridge_hz().into_iter().enumerate() {
            let off = hz - frequency(map.time_s(column));
            assert!(off.abs() <= map.bin_hz, "{column}: {off} Hz, a bin is {} Hz", map.bin_hz);
        }
    }

    #[test]
    fn a_sine_has_its_power() {
        let samples: Vec<f64> = (0..4096).map(|n| 0.7 * (TAU * f64::from(n) * 20.0 / 512.0).sin()).collect();
        let map = stft(&samples, SAMPLE_S, 512, 256);
        assert!(
            map.columns.iter().all(|column| (column[20 * ROWS_PER_BIN] / 0.245 - 1.0).abs() < 1e-12),
            "{}",
            map.columns[3][20 * ROWS_PER_BIN]
        );
        assert_eq!((map.columns.len(), map.time_s(0)), (15, 255.5e-6));
    }

    #[test]
    fn too_few_samples_give_an_empty_map() {
        assert!(stft(&[1.0; 100], SAMPLE_S, 128, 16).columns.is_empty());
        assert!(stft(&[], SAMPLE_S, 0, 0).columns.is_empty());
    }
}
