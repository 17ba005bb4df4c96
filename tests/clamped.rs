//! Clamped branch at power-on and during a run, with the plant at the converters: the remaining
//! bias of the lock point.
//!
//! The firmware's stages are driven one by one, so that the result of a stage can be compared with
//! the exact values at the converters.

mod faults;
mod online;
mod power_on;
mod rig;
mod truth;

/// Mean, standard deviation and largest magnitude of a set of numbers.
struct Spread {
    mean: f64,
    deviation: f64,
    largest: f64,
}

impl Spread {
    fn from_values(x: &[f64]) -> Self {
        let n = x.len() as f64;
        let mean = x.iter().sum::<f64>() / n;
        let deviation = (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
        Spread { mean, deviation, largest: x.iter().fold(0.0, |largest, x| x.abs().max(largest)) }
    }
}

impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.3} ± {:.3} (at most {:.3})", self.mean, self.deviation, self.largest)
    }
}
