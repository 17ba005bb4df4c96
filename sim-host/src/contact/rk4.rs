//! The thesis's method: classical Runge-Kutta of fourth order with a fixed step and the signum in the right-hand side (4.2).
//!
//! At a reversal of the slip the right-hand side has a corner, so the order is two. The integrals that the energy identity needs are
//! states of their own. This is the baseline, written as the thesis's solver does it; nothing here is chosen for accuracy.

use super::Trouble;
use super::problem::{Law, Motion, Problem};
use super::tally::{Meter, State, Tally};
use super::timeline::Timeline;

const METHOD: &str = "rk4";

/// States: x, x', bristle force over Fc; then the integrals of friction, friction power, input and damping.
type Y = [f64; 7];

/// Runs a problem with so many steps a period; `watch` sees the state after every step.
pub fn run(problem: &Problem, steps_per_period: u32, watch: &mut impl FnMut(&State)) -> Result<Tally, Trouble> {
    if problem.law == Law::Coulomb {
        let reason = "Coulomb friction has a jump at every reversal, which needs located events".into();
        return Err(Trouble::Unsuited { method: METHOD, reason });
    }
    let natural_hz = problem.motion.natural_hz().unwrap_or(0.0);
    let mut rates = Rates { problem, coulomb_n: problem.coulomb_n };
    let mut meter = Meter::default();
    meter.tally.accounted = true;
    let mut state = problem.start;
    let mut y: Y = [state.x_m, state.v_m_per_s, state.force_n / rates.coulomb_n, 0.0, 0.0, 0.0, 0.0];
    for stretch in Timeline::new(problem) {
        if let Some(force) = stretch.load {
            y[2] *= rates.coulomb_n / force;
            rates.coulomb_n = force;
        }
        meter.at(&stretch, &state, rates.coulomb_n);
        let steps = stretch.steps(steps_per_period, natural_hz);
        let h = stretch.length_s / f64::from(steps);
        for step in 0..steps {
            let t = stretch.start_s + f64::from(step) * h;
            let before = y;
            rates.step(&mut y, t, h);
            state = rates.state(&y, t + h);
            if !y.iter().all(|value| value.is_finite()) {
                return Err(Trouble::Diverged { method: METHOD, time_s: t });
            }
            let energies = |y: &Y| rates.energies(y);
            let ((k0, p0), (k1, p1)) = (energies(&before), energies(&y));
            let totals = &mut meter.totals;
            [totals.friction_n_s, totals.friction_work_j, totals.input_j, totals.damping_j] = [y[3], y[4], y[5], y[6]];
            (totals.felt_n_s, totals.felt_work_j) = (y[3], y[4]);
            totals.kinetic_j_s += 0.5 * h * (k0 + k1);
            totals.potential_j_s += 0.5 * h * (p0 + p1);
            meter.step(&state, rates.coulomb_n);
            watch(&state);
        }
    }
    Ok(meter.finish(&state, rates.coulomb_n))
}

struct Rates<'a> {
    problem: &'a Problem,
    coulomb_n: f64,
}

impl Rates<'_> {
    fn step(&self, y: &mut Y, t: f64, h: f64) {
        let along = |k: &Y, part: f64| std::array::from_fn(|i| y[i] + part * h * k[i]);
        let k1 = self.of(y, t);
        let k2 = self.of(&along(&k1, 0.5), t + 0.5 * h);
        let k3 = self.of(&along(&k2, 0.5), t + 0.5 * h);
        let k4 = self.of(&along(&k3, 1.0), t + h);
        for (i, value) in y.iter_mut().enumerate() {
            *value += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
    }

    fn of(&self, y: &Y, t: f64) -> Y {
        let forcing = self.problem.waveform.value(t);
        let v = if self.problem.motion == Motion::Kinematic { forcing } else { y[1] };
        let slip = self.problem.sliding_m_per_s + self.problem.sign.factor() * v;
        let (force, bristle_rate) = self.friction(y[2], slip);
        let (a, input, damping) = match self.problem.motion {
            Motion::Kinematic => (0.0, force * v, 0.0),
            Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m: c } => {
                ((forcing - c * v - stiffness_n_per_m * y[0] - force) / mass_kg, forcing * v, c * v * v)
            }
        };
        [v, a, bristle_rate, force, force * slip, input, damping]
    }

    /// Friction, N, and the rate of the bristle force over Fc, 1/s.
    fn friction(&self, bristle: f64, slip: f64) -> (f64, f64) {
        match self.problem.law {
            Law::Coulomb => (self.coulomb_n * slip.signum(), 0.0),
            Law::Dahl { stiffness_n_per_m } => {
                let rate = stiffness_n_per_m / self.coulomb_n * (slip - slip.abs() * bristle);
                (self.coulomb_n * bristle, rate)
            }
            Law::Lugre { stiffness_n_per_m, static_ratio, stribeck_m_per_s, sigma1, sigma2 } => {
                let level = 1.0 + (static_ratio - 1.0) * (-(slip / stribeck_m_per_s).powi(2)).exp();
                let z_rate = slip - slip.abs() * bristle / level;
                let rate = stiffness_n_per_m / self.coulomb_n * z_rate;
                (self.coulomb_n * bristle + sigma1 * z_rate + sigma2 * slip, rate)
            }
        }
    }

    fn state(&self, y: &Y, time_s: f64) -> State {
        let v = if self.problem.motion == Motion::Kinematic { self.problem.waveform.value(time_s) } else { y[1] };
        let slip = self.problem.sliding_m_per_s + self.problem.sign.factor() * v;
        State { time_s, x_m: y[0], v_m_per_s: v, force_n: self.friction(y[2], slip).0 }
    }

    fn energies(&self, y: &Y) -> (f64, f64) {
        match self.problem.motion {
            Motion::Kinematic => (0.0, 0.0),
            Motion::Sdof { mass_kg, stiffness_n_per_m, .. } => {
                (0.5 * mass_kg * y[1] * y[1], 0.5 * stiffness_n_per_m * y[0] * y[0])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::problem::tests::table_4_1;
    use crate::contact::tally::Ratios;

    #[test]
    fn table_4_1_as_the_thesis_steps_it() {
        let problem = table_4_1(0.5, 200.0);
        let tally = run(&problem, 1000, &mut |_| ()).unwrap();
        let ratios = Ratios::of(&problem, &tally);
        println!("{ratios:?} {tally:?}");
        assert!(ratios.energy_residual.unwrap().abs() < 1e-9, "{ratios:?}");
    }
}
