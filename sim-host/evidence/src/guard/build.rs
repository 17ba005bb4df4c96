//! Parameters of one run, and the random numbers by which runs differ.

use crate::random::Random;

/// Parameters of one run.
#[derive(Clone, Copy, Debug)]
pub struct RunParameters {
    /// Speed of the belt, m/s.
    pub speed_m_per_s: f64,
    /// Ripple of the belt's speed, rms, relative to the speed.
    pub ripple_rms: f64,
    /// Counts of the encoder, 1/mm.
    pub counts_per_mm: f64,
    /// Fraction of a count that the belt has passed at the beginning.
    pub phase: f64,
    /// Setting `limits.belt_stop_ms` of the controller.
    pub stop_ms: f64,
    /// Bandwidth of the force channel, Hz, if there is one.
    pub force_hz: Option<f64>,
    /// Setting `limits.energy_j_per_m` of the controller.
    pub energy_j_per_m: Option<f64>,
    /// Setting `limits.on_time_s` of the controller.
    pub on_time_s: Option<f64>,
    /// Seed of the ripple and of the noise.
    pub seed: u64,
}

/// Returns a number from 0 to 1 that is determined by a seed and a salt.
pub fn part(seed: u64, salt: u64) -> f64 {
    Random::new(seed ^ (salt << 32)).part()
}
