//! The clamped branch at power-on and while running, with the plant behind the converters: what is left of the lock point's bias.
//!
//! The firmware's own stages are driven one by one, so that what a stage hands on can be compared with what the converters see exactly.

mod faults;
mod online;
mod power_on;
mod rig;
mod truth;

/// Mean, standard deviation and largest size of some numbers.
struct Spread {
    mean: f64,
    deviation: f64,
    largest: f64,
}

impl Spread {
    fn of(x: &[f64]) -> Self {
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
