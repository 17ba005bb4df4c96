//! What a contact is, from the friction at a few amplitudes, a piece at a time.
//!
//! Two numbers are sought: the Dahl length `l = Fc / Kt`, and a scale of the velocity ratio, because neither the sliding speed nor the force
//! factor, by which a motional current is a tip velocity, is known exactly. Both show in how the friction falls with the amplitude:
//!
//! ```text
//! r_k = r(s Vt / V_k, V_k / (w l)),    k = 1 to 3
//! least of  sum (r_k - measured_k)^2 / dr^2 + (ln s)^2 / ds^2 + (ln l / l0)^2 / dl^2
//! ```
//!
//! by the rule of Levenberg and Marquardt (1963) from the best of a few lengths. What the amplitudes do not show (the length of a contact so
//! soft that it does not matter) stays where it was expected, and its deviation says so.

use heapless::Vec;

use super::dahl::Evaluation;

/// Amplitudes at which the friction is measured.
pub(crate) const AMPLITUDES: usize = 3;

/// By how much a measured ratio scatters.
const RATIO_DEVIATION: f32 = 0.002;
/// By how much the velocity ratio is expected to be off: speed 2 %, force factor 3 %.
const SCALE_DEVIATION: f32 = 0.036;
/// The Dahl length that is expected, m, and by how much it may be off: a factor of e^2.
const LENGTH: (f32, f32) = (0.5e-6, 2.0);
/// Lengths to begin at: as many factors of sqrt 10, from 0.03 um.
const BEGINNINGS: (f32, u32) = (0.03e-6, 7);
/// Steps of the derivatives.
const STEP: [f32; 2] = [0.02, 0.005];
/// Trials after the beginnings.
const MOST_TRIALS: u32 = 12;
/// A step that is this small is the last.
const SMALL_STEP: f32 = 1e-3;

/// Friction at one amplitude.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Observation {
    /// Sliding speed, measured or nominal, m/s.
    pub(crate) speed_m_per_s: f32,
    /// Tip velocity, by the nominal force factor, m/s.
    pub(crate) tip_m_per_s: f32,
    /// Friction over that without vibration.
    pub(crate) ratio: f32,
}

/// A contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    /// Dahl length Fc / Kt, m.
    pub(crate) dahl_length_m: f32,
    /// Times the measured speed over the measured tip velocity is the velocity ratio.
    pub scale: f32,
    /// Standard deviation of the length, relative.
    pub(crate) length_deviation: f32,
}

impl Contact {
    /// The nominal contact: nothing is identified yet.
    pub(crate) fn nominal(dahl_length_m: f32) -> Self {
        Contact { dahl_length_m, scale: 1.0, length_deviation: LENGTH.1 }
    }
}

/// A trial: logarithms of length and scale, and what they predict.
#[derive(Clone, Copy, Debug, Default)]
struct Trial {
    place: [f32; 2],
    ratios: [f32; AMPLITUDES],
    cost: f32,
}

#[derive(Clone, Copy, Debug)]
enum Stage {
    /// One of the lengths to begin at.
    Beginning(u32),
    /// A trial for the derivative by one of the parameters.
    Slope(usize),
    /// A step from the best.
    Trial,
}

/// A fit that is being made.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    omega: f32,
    observations: Vec<Observation, AMPLITUDES>,
    stage: Stage,
    best: Trial,
    slopes: [[f32; AMPLITUDES]; 2],
    trial: Trial,
    /// Which observation is being predicted.
    at: usize,
    evaluation: Evaluation,
    damping: f32,
    trials: u32,
}

impl Fit {
    /// Begins with what was observed at a drive of `omega` rad/s.
    pub(crate) fn new(omega: f32, observations: Vec<Observation, AMPLITUDES>) -> Self {
        let mut fit = Fit {
            omega,
            observations,
            stage: Stage::Beginning(0),
            best: Trial { cost: f32::INFINITY, ..Trial::default() },
            slopes: [[0.0; AMPLITUDES]; 2],
            trial: Trial::default(),
            at: 0,
            evaluation: Evaluation::new(1.0, 0.0),
            damping: 0.01,
            trials: 0,
        };
        fit.begin_at(0);
        fit
    }

    /// Goes on by one step of an evaluation, or of the fit itself; the contact, once it is found.
    pub(crate) fn step(&mut self) -> Option<Contact> {
        if self.at >= self.observations.len() {
            self.trial.cost = self.cost();
            return self.judge();
        }
        let ratio = self.evaluation.step()?;
        if let Some(predicted) = self.trial.ratios.get_mut(self.at) {
            *predicted = ratio;
        }
        self.at += 1;
        self.evaluate();
        None
    }

    fn judge(&mut self) -> Option<Contact> {
        match self.stage {
            Stage::Beginning(n) => {
                self.keep_better();
                if n + 1 < BEGINNINGS.1 { self.begin_at(n + 1) } else { self.slope(0) }
            }
            Stage::Slope(which) => {
                for (slopes, step) in self.slopes.iter_mut().zip(STEP).skip(which).take(1) {
                    for (slope, (to, from)) in slopes.iter_mut().zip(self.trial.ratios.iter().zip(&self.best.ratios)) {
                        *slope = (to - from) / step;
                    }
                }
                if which == 0 { self.slope(1) } else { self.go() }
            }
            Stage::Trial => {
                let moved =
                    self.trial.place.iter().zip(&self.best.place).fold(0.0f32, |most, (to, from)| most.max((to - from).abs()));
                let better = self.keep_better();
                self.damping *= if better { 0.1 } else { 10.0 };
                self.trials += 1;
                if self.trials >= MOST_TRIALS || moved < SMALL_STEP {
                    return Some(self.contact());
                }
                if better { self.slope(0) } else { self.go() }
            }
        }
        None
    }

    /// Takes the trial if it costs less.
    fn keep_better(&mut self) -> bool {
        let better = self.trial.cost < self.best.cost;
        if better {
            self.best = self.trial;
        }
        better
    }

    fn begin_at(&mut self, n: u32) {
        self.stage = Stage::Beginning(n);
        let length = libm::logf(BEGINNINGS.0) + n as f32 * 0.5 * core::f32::consts::LN_10;
        self.predict([length, 0.0]);
    }

    fn slope(&mut self, which: usize) {
        self.stage = Stage::Slope(which);
        let mut place = self.best.place;
        place[which] += STEP[which];
        self.predict(place);
    }

    /// A step down from the best.
    fn go(&mut self) {
        self.stage = Stage::Trial;
        let ([a, b, c], [p, q]) = self.normal();
        let (a, c) = (a * (1.0 + self.damping), c * (1.0 + self.damping));
        let determinant = a * c - b * b;
        let step = [(c * p - b * q) / determinant, (a * q - b * p) / determinant];
        let [length, scale] = self.best.place;
        self.predict([length + step[0].clamp(-2.0, 2.0), (scale + step[1]).clamp(-0.5, 0.5)]);
    }

    /// The normal matrix (its three elements) and the slope downhill, at the best.
    fn normal(&self) -> ([f32; 3], [f32; 2]) {
        const WEIGHT: f32 = 1.0 / (RATIO_DEVIATION * RATIO_DEVIATION);
        let priors = [1.0 / (LENGTH.1 * LENGTH.1), 1.0 / (SCALE_DEVIATION * SCALE_DEVIATION)];
        let expected = [libm::logf(LENGTH.0), 0.0];
        let mut matrix = [priors[0], 0.0, priors[1]];
        let mut downhill = [priors[0] * (expected[0] - self.best.place[0]), priors[1] * (expected[1] - self.best.place[1])];
        let [by_length, by_scale] = &self.slopes;
        let slopes = by_length.iter().zip(by_scale);
        for ((observation, predicted), (x, y)) in self.observations.iter().zip(&self.best.ratios).zip(slopes) {
            let missing = observation.ratio - predicted;
            matrix = [matrix[0] + WEIGHT * x * x, matrix[1] + WEIGHT * x * y, matrix[2] + WEIGHT * y * y];
            downhill = [downhill[0] + WEIGHT * x * missing, downhill[1] + WEIGHT * y * missing];
        }
        (matrix, downhill)
    }

    fn contact(&self) -> Contact {
        let ([a, b, c], _) = self.normal();
        let [length, scale] = self.best.place;
        let length_deviation = libm::sqrtf(c / (a * c - b * b));
        Contact { dahl_length_m: libm::expf(length), scale: libm::expf(scale), length_deviation }
    }

    fn predict(&mut self, place: [f32; 2]) {
        self.trial = Trial { place, ..Trial::default() };
        self.at = 0;
        self.evaluate();
    }

    fn evaluate(&mut self) {
        let Some(observation) = self.observations.get(self.at) else { return };
        let [length, scale] = self.trial.place;
        let xi = libm::expf(scale) * observation.speed_m_per_s / observation.tip_m_per_s;
        self.evaluation = Evaluation::new(xi, observation.tip_m_per_s / (self.omega * libm::expf(length)));
    }

    fn cost(&self) -> f32 {
        let square = |x: f32| x * x;
        let [length, scale] = self.trial.place;
        let prior = square((length - libm::logf(LENGTH.0)) / LENGTH.1) + square(scale / SCALE_DEVIATION);
        let misses = self.observations.iter().zip(&self.trial.ratios);
        misses.fold(prior, |sum, (observation, ratio)| sum + square((observation.ratio - ratio) / RATIO_DEVIATION))
    }
}

#[cfg(test)]
mod tests {
    use super::super::dahl::friction_ratio;
    use super::*;

    const OMEGA: f32 = 2.0 * core::f32::consts::PI * 40e3;

    /// What a contact shows at three amplitudes, if the speed is said to be `1 / scale` of what it is, with errors of the force.
    fn observed(length: f32, scale: f32, errors: [f32; 3]) -> Vec<Observation, AMPLITUDES> {
        let speed = 0.038;
        let tips = [0.175, 0.088, 0.0447];
        let observation = |(tip, error): (f32, f32)| Observation {
            speed_m_per_s: speed / scale,
            tip_m_per_s: tip,
            ratio: friction_ratio(speed / tip, tip / (OMEGA * length)) + error,
        };
        tips.into_iter().zip(errors).map(observation).collect()
    }

    fn fit(observations: Vec<Observation, AMPLITUDES>) -> (Contact, u32) {
        let mut fit = Fit::new(OMEGA, observations);
        let mut steps = 0;
        loop {
            steps += 1;
            if let Some(contact) = fit.step() {
                return (contact, steps);
            }
        }
    }

    /// The worst error of a ratio that is asked for, between those of the maximum amplitude and of the smallest one with an effect.
    fn worst(length: f32, contact: Contact, scale: f32) -> f32 {
        let of = |n: i32| {
            let tip = 0.038 / (0.22 + 0.0075 * n as f32);
            let truth = friction_ratio(0.038 / tip, tip / (OMEGA * length));
            let nominal = contact.scale * 0.038 / scale / tip;
            (friction_ratio(nominal, tip / (OMEGA * contact.dahl_length_m)) - truth).abs()
        };
        (0..=100).map(of).fold(0.0, f32::max)
    }

    /// Lengths of a contact of metal, in um: with a speed that is 2 % off, and what the force sensor adds. Measured: 0.0035 at worst.
    #[test]
    fn any_length_is_known_as_well_as_it_matters() {
        let mut most = 0.0f32;
        for length in [0.1e-6, 0.15e-6, 0.5e-6, 1e-6, 2e-6, 5.36e-6] {
            for scale in [0.98, 1.0, 1.02] {
                for errors in [[0.0; 3], [0.002, -0.002, 0.002], [-0.002, 0.002, 0.002]] {
                    let (contact, _) = fit(observed(length, scale, errors));
                    let error = worst(length, contact, scale);
                    std::println!("{length} {scale} {errors:?}: {contact:?} {error}");
                    most = most.max(error);
                }
            }
        }
        assert!(most < 0.004, "{most}");
    }

    /// Without errors both numbers come back. Measured: length within 0.21 %, scale within 0.04 %, where the length shows at all.
    #[test]
    fn both_numbers_come_back() {
        for length in [0.15e-6, 0.5e-6, 1e-6] {
            for scale in [0.98, 1.02] {
                let (contact, _) = fit(observed(length, scale, [0.0; 3]));
                assert!((contact.dahl_length_m / length - 1.0).abs() < 0.003, "{length} {scale}: {contact:?}");
                assert!((contact.scale / scale - 1.0).abs() < 6e-4, "{length} {scale}: {contact:?}");
            }
        }
    }

    /// What cannot be of this law, or of any, ends in time with numbers.
    #[test]
    fn nonsense_ends() {
        for errors in [[0.5, -0.5, 0.5], [f32::NAN; 3], [f32::INFINITY, 0.0, 0.0], [-3.0; 3]] {
            let (contact, steps) = fit(observed(0.5e-6, 1.0, errors));
            assert!(contact.dahl_length_m > 0.0 && contact.dahl_length_m.is_finite() && steps < 1000, "{errors:?}: {contact:?}");
        }
        let (contact, _) = fit(Vec::new());
        assert!(contact.dahl_length_m > 0.0, "{contact:?}");
    }
}
