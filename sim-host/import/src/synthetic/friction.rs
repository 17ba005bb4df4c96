//! Synthetic friction logs with known truth and Cramér-Rao bounds: contact, motion and noise drawn
//! from a seed.
//!
//! The displacement oscillates. Its amplitude grows from a presliding of a few samples to a hundred
//! times that, with velocities from zero to more than the Stribeck velocity. The noise is reduced
//! until every bound is below a tenth of its value, because a user would repeat a less precise
//! measurement.

use super::random::Random;
use crate::error::ImportError;
use crate::friction::certainty::{links, whitened};
use crate::friction::fit::slopes;
use crate::friction::result::named;
use crate::friction::{Friction, Log, Model, fit};
use crate::least_squares::{Linear, Solution};

/// Largest bound of the logarithm of a parameter.
const MAX_BOUND_LN: f64 = 0.1;

/// Synthetic friction log.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionExample {
    /// Model of the contact.
    pub model: Model,
    /// Friction log.
    pub log: Log,
    /// Correlation of the noise of neighbouring samples.
    pub correlation: f64,
    /// Parameters of the model in the form in which they are fitted.
    truth: Vec<f64>,
    /// Standard deviation of the noise, N.
    noise_n: f64,
}

/// Value of the contact with its bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounded {
    /// Name of the value, as in the result.
    pub name: String,
    /// True value.
    pub value: f64,
    /// Cramér-Rao bound of its standard deviation.
    pub bound: f64,
}

impl FrictionExample {
    /// Draws the example with this number.
    pub fn draw(number: u64) -> Self {
        let mut random = Random::new(number ^ 0xf21c_7105);
        let model = random.one(&Model::SEARCHED);
        let samples = random.one(&[300, 700, 1500]);
        let (cycles, amplitude_m) = (random.between(3.0, 8.0), random.log(2e-5, 2e-2));
        let (fc, normal_n, span_s) = (random.log(0.05, 50.0), random.log(0.5, 100.0), random.log(0.5, 20.0));
        let w = std::f64::consts::TAU * cycles / span_s;
        let at = |n: usize| {
            let t = span_s * n as f64 / samples as f64;
            let a = amplitude_m * (0.1 + t / span_s);
            (t, a * libm::sin(w * t), a * w * libm::cos(w * t) + amplitude_m / span_s * libm::sin(w * t))
        };
        let path: Vec<(f64, f64, f64)> = (0..samples).map(at).collect();
        let mut log = Log {
            time_s: path.iter().map(|(t, ..)| *t).collect(),
            slip_m: std::iter::once(0.0).chain(path.windows(2).map(|pair| pair[1].1 - pair[0].1)).collect(),
            velocity_m_per_s: path.iter().map(|(.., v)| *v).collect(),
            force_n: Vec::new(),
            normal_n,
            on: vec![false; samples],
            remarks: Vec::new(),
        };
        let fastest = amplitude_m * w;
        // Slip per sample at the velocity of the first oscillations.
        let finest = 0.1 * amplitude_m * w * span_s / samples as f64;
        let stiffness = fc / (finest * random.log(3.0, 30.0));
        let value = |name: &str, random: &mut Random| match name {
            "coulomb_n" => fc,
            "static_excess_n" => fc * random.between(0.15, 0.8),
            "stribeck_m_per_s" => fastest * random.between(0.1, 0.4),
            "sigma2" => fc / fastest * random.log(0.05, 0.5),
            "stiffness_n_per_m" => stiffness,
            _ => fc * random.between(-0.5, 0.5),
        };
        let truth: Vec<f64> = model
            .parameters()
            .iter()
            .map(|(name, log)| {
                let value = value(name, &mut random);
                if *log { libm::log(value) } else { value }
            })
            .collect();
        let correlation = if random.chance(0.25) { random.between(0.3, 0.9) } else { 0.0 };
        let exact = model.force(&truth, &log);
        let mut example = FrictionExample { model, log: log.clone(), correlation, truth, noise_n: fc * random.log(2e-3, 3e-2) };
        example.noise_n *= example.noise_factor();
        let mut last = random.normal();
        let noise = |_: &f64| {
            let now = last;
            last = correlation * last + (1.0 - correlation * correlation).sqrt() * random.normal();
            example.noise_n * now
        };
        log.force_n = exact.iter().map(noise).zip(&exact).map(|(noise, exact)| exact + noise).collect();
        FrictionExample { log, ..example }
    }

    /// Returns the factor of the noise with which every bound is small enough.
    fn noise_factor(&self) -> f64 {
        let Some(covariance) = self.covariance() else { return 1e-3 };
        let relative = |(at, (name, log)): (usize, &(&str, bool))| match (*name, *log) {
            ("initial_force_n", _) => 0.0,
            (_, true) => covariance[(at, at)].sqrt(),
            (_, false) => covariance[(at, at)].sqrt() / self.truth[at].abs(),
        };
        let largest = self.model.parameters().iter().enumerate().map(relative).fold(0.0, f64::max);
        (MAX_BOUND_LN / largest).min(1.0)
    }

    /// Returns the smallest covariance of an unbiased estimate of the parameters.
    fn covariance(&self) -> Option<nalgebra::DMatrix<f64>> {
        let columns = slopes(
            self.model,
            &self.truth,
            |fitted| {
                let force = self.model.force(fitted, &self.log);
                force.iter().all(|force| force.is_finite()).then(|| force.iter().map(|force| force / self.noise_n).collect())
            },
            None,
        )?;
        let residuals = vec![0.0; columns.first()?.len()];
        let places: Vec<usize> = (0..residuals.len()).collect();
        let linear = whitened(&Linear { residuals, columns }, &links(self.correlation, &places));
        Solution { parameters: self.truth.clone(), linear, cost: 0.0, converged: true }.covariance()
    }

    /// Fits the contact to the log.
    ///
    /// # Errors
    /// Returns [`ImportError`], as for a log of a user.
    pub fn import(&self) -> Result<Friction, ImportError> {
        fit("example", self.log.clone())
    }

    /// Returns the values of the contact with their bounds; `None` if the log does not determine
    /// them.
    pub fn bounds(&self) -> Option<Vec<Bounded>> {
        let covariance = self.covariance()?;
        let all = named(self.model, &self.truth, &|i, j| covariance[(i, j)], self.log.normal_n);
        Some(all.into_iter().map(|(name, value, bound)| Bounded { name, value, bound }).collect())
    }
}
