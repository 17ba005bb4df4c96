//! The force channel of the controller: a second-order Butterworth low-pass like that of the load
//! cell but faster, with noise, read once a block.

use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::load_cell::LoadCell;

/// Force channel: a force sensor with a low pass and noise.
#[derive(Clone, Debug)]
pub struct ForceChannel {
    cell: LoadCell,
    noise_n: f64,
    random: Xoshiro256PlusPlus,
}

impl ForceChannel {
    /// Creates a channel of this bandwidth that is read every `step_s` seconds, with noise of this
    /// rms on each reading, N.
    pub fn new(bandwidth_hz: f64, step_s: f64, noise_n: f64, seed: u64) -> Self {
        ForceChannel { cell: LoadCell::new(bandwidth_hz, step_s), noise_n, random: Xoshiro256PlusPlus::seed_from_u64(seed) }
    }

    /// Applies a mean force over one step. Returns the reading at its end, N.
    pub fn measure(&mut self, force_n: f64) -> f32 {
        let normal: f64 = StandardNormal.sample(&mut self.random);
        (self.cell.measure(force_n) + self.noise_n * normal) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2.8 / (2 pi 500 Hz) = 0.9 ms to 90 %.
    #[test]
    fn follows_a_step_within_a_millisecond_under_its_noise() {
        let mut channel = ForceChannel::new(500.0, 32e-6, 0.02, 1);
        let readings: Vec<f64> = (0..20_000).map(|_| channel.measure(2.0).into()).collect();
        let rise_ms = readings.iter().position(|&n| n > 1.8).map(|n| n as f64 * 32e-3);
        assert!(rise_ms.is_some_and(|ms| (0.7..1.0).contains(&ms)), "{rise_ms:?}");
        let settled = &readings[1000..];
        let mean = settled.iter().sum::<f64>() / settled.len() as f64;
        let noise = (settled.iter().map(|n| (n - mean).powi(2)).sum::<f64>() / settled.len() as f64).sqrt();
        assert!((mean - 2.0).abs() < 6e-4 && (noise - 0.02).abs() < 4e-4, "{mean} {noise}");
    }
}
