//! Synthetic friction logs with known truth and Cramér-Rao bounds: contact, motion, instrument and
//! noise drawn from a seed.
//!
//! The displacement oscillates. Its amplitude grows from a presliding of a few samples to a hundred
//! times that, with velocities from zero to more than the Stribeck velocity. The contact is
//! integrated in time by the method of Runge and Kutta, in steps that are much shorter than a
//! sample and do not depend on reversals. No code of the fit takes part.
//!
//! The instrument has uneven times of its samples, a normal force that may vary, a filter of first
//! order in both channels, a resolution of displacement and force below the noise, and an offset
//! that drifts. The noise is reduced until every bound of a contact parameter is below a tenth of
//! its value, because a user would repeat a less precise measurement.

use super::random::Random;
use crate::error::ImportError;
use crate::friction::certainty::{links, whitened};
use crate::friction::motion::drift;
use crate::friction::result::named;
use crate::friction::smoothed::Smoothed;
use crate::friction::{Friction, Log, Model, fit};
use crate::least_squares::{Linear, Solution};

/// Steps of the integration in a sample.
const STEPS: usize = 32;
/// Parameters of the baseline of the force: offset and drift.
const BASELINE: usize = 2;
/// Step of a parameter for the derivatives of the bounds.
const SLOPE_STEP: f64 = 1e-5;
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
    /// Times of the samples, s.
    times_s: Vec<f64>,
    /// True motion and instrument.
    rig: Rig,
    /// Parameters of the model in the form in which they are fitted.
    truth: Vec<f64>,
    /// Standard deviation of the noise, N.
    noise_n: f64,
    /// Smallest covariance of an unbiased estimate of the parameters, for noise of 1 N; `None` if
    /// the log does not determine them.
    unit_covariance: Option<nalgebra::DMatrix<f64>>,
}

/// Motion of the contact and filter of its instrument.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rig {
    amplitude_m: f64,
    /// Angular frequency of the motion, rad/s.
    w: f64,
    span_s: f64,
    normal_n: f64,
    /// Amplitude of the normal force, relative to its mean.
    normal_swing: f64,
    /// Time constant of the filter, s.
    filter_s: f64,
}

impl Rig {
    /// Returns displacement, m, velocity, m/s, and normal force, relative to the mean.
    fn at(&self, t: f64) -> (f64, f64, f64) {
        let (a, sin) = (self.amplitude_m * (0.1 + t / self.span_s), libm::sin(self.w * t));
        let v = a * self.w * libm::cos(self.w * t) + self.amplitude_m / self.span_s * sin;
        (a * sin, v, 1.0 + self.normal_swing * libm::sin(0.37 * self.w * t))
    }

    /// Returns the filtered values of a signal at the times of the samples.
    fn filtered(&self, times_s: &[f64], mut signal: impl FnMut(f64, f64) -> f64) -> Vec<f64> {
        let mut last = signal(times_s[0], 0.0);
        let mut filtered = last;
        let mut samples = vec![filtered];
        for pair in times_s.windows(2) {
            let h = (pair[1] - pair[0]) / STEPS as f64;
            for n in 0..STEPS {
                let now = signal(pair[0] + h * n as f64, h);
                // Linear between the steps.
                let lag = (now - last) / h * self.filter_s;
                filtered = now - lag + (filtered - last + lag) * libm::exp(-h / self.filter_s);
                last = now;
            }
            samples.push(filtered);
        }
        samples
    }

    /// Returns the filtered force of a contact, N, without noise.
    fn force(&self, model: Model, fitted: &[f64], times_s: &[f64]) -> Vec<f64> {
        let value = |wanted: &str| {
            let found = model.parameters(BASELINE).into_iter().zip(fitted).find(|((name, _), _)| *name == wanted);
            found.map(|((_, log), p)| if log { libm::exp(*p) } else { *p })
        };
        let [fc, excess, viscous, mut spring, offset, slope] =
            ["coulomb_n", "static_excess_n", "sigma2", "initial_force_n", "offset_n", "drift_n"]
                .map(|name| value(name).unwrap_or(0.0));
        let (vs, stiffness) = (value("stribeck_m_per_s").unwrap_or(1.0), value("stiffness_n_per_m"));
        let limit = |v: f64, normal: f64| normal * (fc + excess * libm::exp(-(v / vs) * (v / vs)));
        let rate = |t: f64, spring: f64, kt: f64| {
            let (_, v, normal) = self.at(t);
            kt * (v - v.abs() * spring / limit(v, normal))
        };
        let force = |t: f64, h: f64| {
            let (_, v, normal) = self.at(t + h);
            let Some(kt) = stiffness else { return v.signum() * limit(v, normal) + viscous * v };
            let k1 = rate(t, spring, kt);
            let k2 = rate(t + 0.5 * h, spring + 0.5 * h * k1, kt);
            let k3 = rate(t + 0.5 * h, spring + 0.5 * h * k2, kt);
            let k4 = rate(t + h, spring + h * k3, kt);
            spring += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            spring + viscous * v
        };
        let mut samples = self.filtered(times_s, force);
        samples.iter_mut().enumerate().for_each(|(at, force)| *force += offset + slope * drift(at, times_s.len()));
        samples
    }
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
        let (mu, normal_n, span_s) = (random.log(0.02, 1.5), random.log(0.5, 100.0), random.log(0.5, 20.0));
        let fc = mu * normal_n;
        let w = std::f64::consts::TAU * cycles / span_s;
        let interval_s = span_s / samples as f64;
        let normal_swing = if random.chance(0.5) { random.between(0.1, 0.6) } else { 0.0 };
        let filter_s = interval_s * random.log(0.005, 0.1);
        let rig = Rig { amplitude_m, w, span_s, normal_n, normal_swing, filter_s };
        let jitter = random.between(0.0, 0.2);
        let times_s: Vec<f64> = (0..samples).map(|n| interval_s * (n as f64 + random.between(-jitter, jitter))).collect();
        let fastest = amplitude_m * w;
        // Slip per sample at the velocity of the first oscillations.
        let finest = 0.1 * amplitude_m * w * interval_s;
        let stiffness = fc / (finest * random.log(3.0, 30.0));
        let value = |name: &str, random: &mut Random| match name {
            "coulomb_n" => fc,
            "static_excess_n" => fc * random.between(0.15, 0.8),
            "stribeck_m_per_s" => fastest * random.between(0.1, 0.4),
            "sigma2" => fc / fastest * random.log(0.05, 0.5),
            "stiffness_n_per_m" => stiffness,
            "drift_n" => fc * random.between(-0.1, 0.1),
            _ => fc * random.between(-0.5, 0.5),
        };
        let fitted = |(name, log): (&'static str, bool)| {
            let value = value(name, &mut random);
            if log { libm::log(value) } else { value }
        };
        let truth: Vec<f64> = model.parameters(BASELINE).into_iter().map(fitted).collect();
        let correlation = if random.chance(0.25) { random.between(0.3, 0.9) } else { 0.0 };
        let noise_n = fc * random.log(2e-3, 3e-2);
        let mut example =
            FrictionExample { model, log: Log::default(), correlation, times_s, rig, truth, noise_n, unit_covariance: None };
        example.unit_covariance = example.unit_covariance();
        example.noise_n *= example.noise_factor();
        let mut last = random.normal();
        let mut noise = || {
            let now = last;
            last = correlation * last + (1.0 - correlation * correlation).sqrt() * random.normal();
            example.noise_n * now
        };
        let exact = rig.force(model, &example.truth, &example.times_s);
        let force_n: Vec<f64> = exact.into_iter().map(|exact| exact + noise()).collect();
        let rounded =
            |values: Vec<f64>, step: f64| values.into_iter().map(|value| step * libm::round(value / step)).collect::<Vec<_>>();
        let force_n = rounded(force_n, example.noise_n * random.log(0.1, 1.0));
        let resolution_m = (finest * random.log(2e-3, 3e-2)).min(example.noise_n / stiffness);
        let x = rounded(rig.filtered(&example.times_s, |t, h| rig.at(t + h).0), resolution_m);
        let smoothed = Smoothed::new(&example.times_s, &x);
        let normals_n: Vec<f64> = example.times_s.iter().map(|t| normal_n * rig.at(*t).2).collect();
        let log = Log {
            noise_m: 0.0,
            time_s: example.times_s.clone(),
            slip_m: std::iter::once(0.0).chain(smoothed.x_m.windows(2).map(|pair| pair[1] - pair[0])).collect(),
            velocity_m_per_s: smoothed.velocity_m_per_s,
            force_n,
            normal_n,
            normals_n: if normal_swing > 0.0 { normals_n } else { Vec::new() },
            on: vec![false; samples],
            remarks: Vec::new(),
        };
        FrictionExample { log, ..example }
    }

    /// Returns the factor of the noise with which every bound is small enough.
    fn noise_factor(&self) -> f64 {
        let Some(covariance) = &self.unit_covariance else { return 1e-3 };
        let relative = |(at, (name, log)): (usize, &(&str, bool))| match (*name, *log) {
            ("initial_force_n" | "offset_n" | "drift_n", _) => 0.0,
            (_, true) => covariance[(at, at)].sqrt(),
            (_, false) => covariance[(at, at)].sqrt() / self.truth[at].abs(),
        };
        let largest = self.model.parameters(BASELINE).iter().enumerate().map(relative).fold(0.0, f64::max);
        (MAX_BOUND_LN / (largest * self.noise_n)).min(1.0)
    }

    /// Computes the smallest covariance by derivatives of the integrated contact.
    fn unit_covariance(&self) -> Option<nalgebra::DMatrix<f64>> {
        let parameters = self.model.parameters(BASELINE);
        let column = |(at, (_, log)): (usize, &(&str, bool))| {
            let step = if *log { SLOPE_STEP } else { SLOPE_STEP * (1e-3 + self.truth[at].abs()) };
            let moved = |by: f64| {
                let mut moved = self.truth.clone();
                moved[at] += by;
                self.rig.force(self.model, &moved, &self.times_s)
            };
            moved(step).iter().zip(moved(-step)).map(|(up, down)| (up - down) / (2.0 * step)).collect()
        };
        let columns: Vec<Vec<f64>> = parameters.iter().enumerate().map(column).collect();
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
        let unit = self.unit_covariance.as_ref()?;
        let covariance = |i: usize, j: usize| unit[(i, j)] * self.noise_n * self.noise_n;
        let all = named(&self.model.parameters(BASELINE), &self.truth, &covariance, self.log.normal_n);
        Some(all.into_iter().map(|(name, value, bound)| Bounded { name, value, bound }).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_independent_integration_agrees_with_the_fit() {
        let (mut all, mut covered) = (0, 0);
        for number in 0..16 {
            let example = FrictionExample::draw(number);
            let found = example.import().unwrap();
            let fitted = found.chosen();
            assert_eq!(fitted.model, example.model, "{number}");
            assert!(fitted.rms_n < 1.2 * example.noise_n, "{number}: {} {}", fitted.rms_n, example.noise_n);
            for bounded in example.bounds().unwrap() {
                let (_, value, sd) = fitted.parameters.iter().find(|(name, ..)| *name == bounded.name).unwrap();
                let deviations = (value - bounded.value) / sd.unwrap();
                assert!(deviations.abs() < 4.0, "{number} {}: {deviations}", bounded.name);
                (all, covered) = (all + 1, covered + i32::from(deviations.abs() < 1.96));
            }
        }
        assert!(covered * 100 >= all * 90, "{covered} of {all}");
    }
}
