//! The closed form as the solution of a [`Problem`].

use super::super::SolveError;
use super::super::problem::{Law, Motion, Problem};
use super::super::tally::{Ratios, State};
use super::super::waveform::Shape;
use super::lines::Lines;
use super::{Steady, forget, friction_ratio, input_ratio, power_ratio};

const METHOD: &str = "closed";

/// Number of steps into which the displayed period is divided.
const PERIOD_STEPS: u32 = 256;

/// Steady state of a problem; its integrals are computed only when [`ratios`](Self::ratios) is
/// called.
#[derive(Clone, Debug)]
pub struct ClosedForm {
    /// Velocity ratio Vt / Vv; infinite without vibration.
    pub velocity_ratio: f64,
    /// `Kt Vv / (w Fc)`; infinite for Coulomb friction.
    pub kappa: f64,
    /// Fraction of a difference in friction at the start that remains after one period.
    pub forget_per_period: f64,
    vibration: Vibration,
    /// Sign of the vibration in the slip velocity.
    factor: f64,
}

/// Vibration over the steady period.
#[derive(Clone, Debug)]
enum Vibration {
    /// No vibration: sliding alone.
    Still,
    Sine,
    Lines(Lines),
}

impl ClosedForm {
    /// Solves a kinematic problem whose vibration is a sine, square, sawtooth or triangle, with
    /// Coulomb or Dahl friction.
    ///
    /// Window and start have no effect: the solution is the limit for every start, up to
    /// [`start_left`](Self::start_left). With a prescribed motion, friction has no feedback, so the
    /// literal sign only reverses the vibration. A reversed sine, square or triangle is the same
    /// wave half a period later: the ratios stay and the force shifts. A rising sawtooth becomes a
    /// falling one.
    ///
    /// # Errors
    /// [`SolveError::Unsuited`] with the reason, for any other problem.
    pub fn new(problem: &Problem) -> Result<Self, SolveError> {
        let factor = problem.sign.factor();
        let (xi, kappa) = coordinates(problem)?;
        let (forget_per_period, vibration) = match Lines::new(problem.waveform.shape(), factor, xi, kappa) {
            _ if xi.is_infinite() => {
                // Slip of a period in Dahl lengths.
                let slip = match problem.law {
                    Law::Dahl { stiffness_n_per_m } => {
                        stiffness_n_per_m * problem.sliding_m_per_s.abs() / (problem.waveform.frequency_hz() * problem.coulomb_n)
                    }
                    _ => f64::INFINITY,
                };
                ((-slip).exp(), Vibration::Still)
            }
            Some(lines) => (lines.forget(), Vibration::Lines(lines)),
            None => (forget(xi, kappa), Vibration::Sine),
        };
        Ok(ClosedForm { velocity_ratio: xi, kappa, forget_per_period, vibration, factor })
    }

    /// Returns the means over whole periods. The residual of their energy identity is the error of
    /// the integrals.
    pub fn ratios(&self) -> Ratios {
        match &self.vibration {
            Vibration::Still => sine_ratios(f64::signum(self.velocity_ratio), self.kappa, self.factor),
            Vibration::Sine => sine_ratios(self.velocity_ratio, self.kappa, self.factor),
            Vibration::Lines(lines) => lines.ratios(self.factor),
        }
    }

    /// Passes one steady period of the problem from time zero to `watch`, both ends included.
    pub fn show(&self, problem: &Problem, watch: &mut impl FnMut(&State)) {
        let (hz, shape) = (problem.waveform.frequency_hz(), problem.waveform.shape());
        let peak = vibration_m_per_s(problem);
        let (xi, shift_turns) = match self.vibration {
            Vibration::Still => (f64::signum(self.velocity_ratio), 0.0),
            _ => (self.velocity_ratio, if self.factor < 0.0 { 0.5 } else { 0.0 }),
        };
        let steady = Steady::new(xi, self.kappa);
        for step in 0..=PERIOD_STEPS {
            let turns = f64::from(step) / f64::from(PERIOD_STEPS);
            let force = match &self.vibration {
                Vibration::Lines(lines) => lines.force(turns),
                Vibration::Still | Vibration::Sine => steady.force(turns + shift_turns),
            };
            watch(&State {
                time_s: turns / hz,
                x_m: problem.start.x_m + peak / hz * displacement(shape, turns),
                v_m_per_s: problem.waveform.value(turns / hz),
                force_n: problem.coulomb_n * force,
            });
        }
    }

    /// Returns an upper bound of the difference from the steady friction after `periods`, as a
    /// fraction of Fc, for any start (|F| <= Fc).
    pub fn start_left(&self, periods: f64) -> f64 {
        2.0 * self.forget_per_period.powf(periods)
    }
}

fn sine_ratios(xi: f64, kappa: f64, factor: f64) -> Ratios {
    let friction = friction_ratio(xi, kappa);
    // Ratios over Fc Vt change sign with the sliding; in the mirrored problem, x' has the opposite
    // sign.
    let signed = |ratio: Option<f64>| ratio.map(|ratio| ratio * xi.signum());
    let (power, moving) = (signed(power_ratio(xi, kappa)), signed(input_ratio(xi, kappa)));
    let residual = power.zip(moving).map(|(power, moving)| power - (friction + moving));
    Ratios {
        friction,
        power,
        input: moving.map(|moving| factor * moving),
        stored: power.map(|_| 0.0),
        damping: power.map(|_| 0.0),
        power_as_printed: None,
        energy_residual: residual,
    }
}

/// Returns the peak velocity of the vibration, m/s.
fn vibration_m_per_s(problem: &Problem) -> f64 {
    if problem.waveform.shape() == Shape::Still { 0.0 } else { problem.waveform.amplitude() }
}

/// Returns velocity ratio and kappa of a problem that has a closed form.
fn coordinates(problem: &Problem) -> Result<(f64, f64), SolveError> {
    suits(problem)?;
    let vibration = vibration_m_per_s(problem);
    let xi = problem.sliding_m_per_s / vibration;
    let kappa = if vibration == 0.0 && problem.law != Law::Coulomb { 0.0 } else { problem.kappa() };
    if xi.is_nan() || vibration < 0.0 {
        return unsuited("there is neither sliding nor vibration");
    }
    Ok((xi, kappa))
}

fn suits(problem: &Problem) -> Result<(), SolveError> {
    if problem.motion != Motion::Kinematic {
        return unsuited("the oscillator's motion depends on friction; only a prescribed vibration has a closed form");
    }
    if matches!(problem.law, Law::Lugre { .. }) {
        return unsuited("LuGre friction has no closed form; Coulomb and Dahl friction do");
    }
    if matches!(problem.waveform.shape(), Shape::Random { .. } | Shape::Chirp { .. } | Shape::Measured) {
        return unsuited("the vibration is not periodic");
    }
    if !problem.load_steps.is_empty() {
        return unsuited("load steps end the steady state");
    }
    if !(problem.coulomb_n > 0.0 && problem.coulomb_n.is_finite()) {
        return unsuited("the Coulomb force must be positive and finite");
    }
    Ok(())
}

fn unsuited<T>(reason: &str) -> Result<T, SolveError> {
    Err(SolveError::Unsuited { method: METHOD, reason: reason.to_owned() })
}

/// Returns the displacement since the beginning of the period, over Vv times the period.
fn displacement(shape: Shape, turns: f64) -> f64 {
    let rising = |part: f64| part * (2.0 * part - 1.0);
    match shape {
        Shape::Square => turns.min(1.0 - turns),
        Shape::Sawtooth => turns * (turns - 1.0),
        Shape::Triangle if turns <= 0.5 => rising(turns),
        Shape::Triangle => -rising(turns - 0.5),
        _ => (std::f64::consts::TAU * turns).sin() / std::f64::consts::TAU,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table_4_1::table_4_1;
    use crate::{Sign, Waveform};

    /// Returns the thesis's contact with a prescribed vibration.
    fn kinematic(shape: Shape, xi: f64, periods: f64) -> Problem {
        let mut problem = table_4_1(xi, periods);
        let vibration = problem.vibration_m_per_s();
        problem.motion = Motion::Kinematic;
        problem.waveform = Waveform::new(shape, vibration, 60e3, problem.duration_s);
        problem
    }

    const SHAPES: [Shape; 4] = [Shape::Sine, Shape::Square, Shape::Sawtooth, Shape::Triangle];

    /// Friction at xi = 0.5 to five digits, from a separate study of the thesis's waveforms.
    #[test]
    fn square_and_sawtooth() {
        for (shape, friction, power) in [(Shape::Square, 0.45598, 0.63207), (Shape::Sawtooth, 0.74381, 0.80812)] {
            let ratios = ClosedForm::new(&kinematic(shape, 0.5, 1.0)).unwrap().ratios();
            assert!((ratios.friction - friction).abs() < 5e-6, "{shape:?} {}", ratios.friction);
            assert!((ratios.power.unwrap() - power).abs() < 5e-6, "{shape:?} {:?}", ratios.power);
        }
    }

    /// On a line that crosses zero, the layer after a reversal scales with 1 / sqrt kappa; the
    /// residual stays at round-off.
    #[test]
    fn stiff_contacts_tend_to_coulomb() {
        for shape in SHAPES {
            for xi in [0.1, 0.5, 0.9] {
                let at = |law: Law| {
                    let problem = Problem { law, ..kinematic(shape, xi, 1.0) };
                    ClosedForm::new(&problem).unwrap().ratios()
                };
                let coulomb = at(Law::Coulomb);
                for (kt, near) in [(0.056e9, 5e-2), (0.056e12, 2e-3), (0.056e18, 2e-6)] {
                    let dahl = at(Law::Dahl { stiffness_n_per_m: kt });
                    assert!((dahl.friction - coulomb.friction).abs() < near, "{shape:?} {xi} {kt}: {dahl:?} {coulomb:?}");
                    assert!(dahl.energy_residual.unwrap().abs() * xi < 2e-15, "{shape:?} {xi} {kt}: {dahl:?}");
                }
                assert!(coulomb.energy_residual.unwrap().abs() * xi < 1e-15, "{coulomb:?}");
            }
        }
        let square = Problem { law: Law::Coulomb, ..kinematic(Shape::Square, 0.25, 1.0) };
        let ratios = ClosedForm::new(&square).unwrap().ratios();
        assert!(ratios.friction.abs() < 1e-16 && (ratios.power.unwrap() - 4.0).abs() < 1e-15, "{ratios:?}");
    }

    /// The period passed to the observer has the stated means, is closed, and moves with the
    /// velocity x'.
    #[test]
    fn one_period_is_reported() {
        for shape in SHAPES {
            for sign in [Sign::Passive, Sign::Literal] {
                let problem = Problem { sign, ..kinematic(shape, 0.3, 1.0) };
                let mut states = Vec::new();
                let closed = ClosedForm::new(&problem).unwrap();
                closed.show(&problem, &mut |state| states.push(*state));
                let (first, last) = (states[0], states[states.len() - 1]);
                assert!((first.force_n - last.force_n).abs() < 1e-12 && (first.x_m - last.x_m).abs() < 1e-20, "{shape:?}");
                let mut mean = 0.0;
                for pair in states.windows(2) {
                    let step = pair[1].time_s - pair[0].time_s;
                    mean += 0.5 * (pair[0].force_n + pair[1].force_n) * step;
                    let moved = (pair[1].x_m - pair[0].x_m) / step;
                    let middle = problem.waveform.value(0.5 * (pair[0].time_s + pair[1].time_s));
                    assert!((moved - middle).abs() < 2e-5, "{shape:?} {moved} {middle}");
                    assert!(pair[0].force_n.abs() <= problem.coulomb_n);
                }
                let mean = mean / (last.time_s * problem.coulomb_n);
                assert!(
                    (mean - closed.ratios().friction).abs() < 1e-4,
                    "{shape:?} {sign:?}: {mean} {}",
                    closed.ratios().friction
                );
            }
        }
    }

    #[test]
    fn problems_without_closed_form_are_refused() {
        let good = kinematic(Shape::Sine, 0.5, 10.0);
        assert!(ClosedForm::new(&good).is_ok());
        let lugre = Law::Lugre { stiffness_n_per_m: 1e5, static_ratio: 1.5, stribeck_m_per_s: 0.01, sigma1: 0.0, sigma2: 0.0 };
        let random = Waveform::new(Shape::Random { hold_s: 1e-6, seed: 1 }, 0.1, 60e3, 1e-3);
        for bad in [
            table_4_1(0.5, 10.0),
            Problem { law: lugre, ..good.clone() },
            Problem { waveform: random, ..good.clone() },
            Problem { load_steps: vec![(1e-5, 0.1)], ..good.clone() },
            Problem { coulomb_n: 0.0, ..good.clone() },
            Problem { waveform: Waveform::new(Shape::Sine, 0.0, 60e3, 1e-3), sliding_m_per_s: 0.0, ..good.clone() },
        ] {
            assert!(matches!(ClosedForm::new(&bad), Err(SolveError::Unsuited { .. })), "{bad:?}");
        }
        let still = Problem { waveform: Waveform::new(Shape::Still, 0.1, 60e3, 1e-3), ..good };
        let closed = ClosedForm::new(&still).unwrap();
        assert_eq!((closed.ratios().friction, closed.ratios().power, closed.kappa), (1.0, Some(1.0), 0.0));
    }
}
