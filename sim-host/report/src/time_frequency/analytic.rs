//! The analytic signal (Gabor 1946): the positive frequencies of a real signal, doubled. Its square
//! has no terms between the positive frequencies and their mirror images, and its distribution
//! needs only half the sample rate.

use realfft::num_complex::Complex;
use rustfft::FftPlanner;

/// Returns the analytic signal of samples by a transform over all of them. Its real part equals the
/// samples.
pub fn analytic(samples: &[f64]) -> Vec<Complex<f64>> {
    let count = samples.len();
    let mut signal: Vec<Complex<f64>> = samples.iter().map(|&sample| Complex::new(sample, 0.0)).collect();
    let mut planner = FftPlanner::new();
    planner.plan_fft_forward(count).process(&mut signal);
    // Neither the mean nor the frequency of half the sample rate has a mirror image.
    for (bin, value) in signal.iter_mut().enumerate() {
        *value *= match bin {
            0 => 1.0,
            bin if 2 * bin == count => 1.0,
            bin if 2 * bin < count => 2.0,
            _ => 0.0,
        } / count as f64;
    }
    planner.plan_fft_inverse(count).process(&mut signal);
    signal
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cosine_becomes_a_circle() {
        for count in [100, 101] {
            let turn = |n: usize| std::f64::consts::TAU * 7.0 * n as f64 / count as f64;
            let samples: Vec<f64> = (0..count).map(|n| 0.5 + turn(n).cos()).collect();
            for (n, z) in analytic(&samples).into_iter().enumerate() {
                let circle = Complex::new(0.5 + turn(n).cos(), turn(n).sin());
                assert!((z - circle).norm() < 1e-13, "{n}: {z}");
            }
        }
    }
}
