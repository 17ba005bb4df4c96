//! The thesis's method, optimized without changing its result: the baseline for speed comparisons.
//!
//! The steps equal those of [`contact::rk4`] to round-off, but use units that save
//! multiplications, and take the cosine from a table with two entries per step. With
//! `X = s (Kt/Fc) x`, `U = s (Kt/Fc) h x'` and the step h as the unit of time,
//!
//! ```text
//! X' = U,   U' = D cos(2 pi i / n) - a X - d U - e f,   W = p + U,   f' = W - |W| f
//! a = Ks h^2 / m,   d = c h / m,   e = s Kt h^2 / m,   D = e F0 / Fc,   p = Kt Vt h / Fc
//! ```

use std::f64::consts::TAU;

use contact::tally::Meter;
use contact::timeline::{Stretch, Timeline};
use contact::{Law, Motion, Problem, Shape, SolveError, State, Tally};

const METHOD: &str = "rk4 tabulated";

/// Runs a Dahl oscillator under a sine in steps of equal length. The tally contains the mean of
/// friction, but neither energies nor peaks.
pub fn run(problem: &Problem, steps_per_period: u32, watch: &mut impl FnMut(&State)) -> Result<Tally, SolveError> {
    let (Law::Dahl { .. }, Motion::Sdof { .. }, Shape::Sine) = (problem.law, problem.motion, problem.waveform.shape()) else {
        return unsuited("it only solves a Dahl contact on an oscillator under a sine");
    };
    let mut table: Vec<f64> = Vec::new();
    let mut meter = Meter::default();
    let mut coulomb_n = problem.coulomb_n;
    let mut state = problem.start;
    for stretch in Timeline::new(problem) {
        if stretch.template.is_none() {
            return unsuited("a stretch is not a whole period");
        }
        coulomb_n = stretch.load.unwrap_or(coulomb_n);
        let steps = stretch.steps(steps_per_period);
        if table.is_empty() || stretch.load.is_some() {
            let scales = Scales::new(problem, coulomb_n, stretch.length_s / f64::from(steps));
            let half_step = TAU / f64::from(2 * steps);
            table = (0..=2 * steps).map(|entry| scales.drive * (half_step * f64::from(entry)).cos()).collect();
        }
        meter.at(&stretch, &state, coulomb_n);
        let scales = Scales::new(problem, coulomb_n, stretch.length_s / f64::from(steps));
        state = scales.period(&table, &stretch, &state, &mut meter, watch)?;
    }
    Ok(meter.finish(&state, coulomb_n))
}

fn unsuited<T>(reason: &str) -> Result<T, SolveError> {
    Err(SolveError::Unsuited { method: METHOD, reason: reason.into() })
}

/// Factors of the scaled equations.
struct Scales {
    coulomb_n: f64,
    h: f64,
    /// X over x, 1/m.
    per_m: f64,
    /// U over x', s/m.
    per_m_per_s: f64,
    stiffness: f64,
    damping: f64,
    friction: f64,
    drive: f64,
    sliding: f64,
}

impl Scales {
    fn new(problem: &Problem, coulomb_n: f64, h: f64) -> Self {
        let kt = if let Law::Dahl { stiffness_n_per_m } = problem.law { stiffness_n_per_m } else { 0.0 };
        let (mass, ks, c) = match problem.motion {
            Motion::Kinematic => (1.0, 0.0, 0.0),
            Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } => (mass_kg, stiffness_n_per_m, damping_n_s_per_m),
        };
        let per_m = problem.sign.factor() * kt / coulomb_n;
        let friction = problem.sign.factor() * kt * h * h / mass;
        Scales {
            coulomb_n,
            h,
            per_m,
            per_m_per_s: per_m * h,
            stiffness: ks * h * h / mass,
            damping: c * h / mass,
            friction,
            drive: friction * problem.waveform.amplitude() / coulomb_n,
            sliding: kt / coulomb_n * problem.sliding_m_per_s * h,
        }
    }

    /// Integrates one period and returns the state at its end.
    fn period(
        &self,
        table: &[f64],
        stretch: &Stretch,
        from: &State,
        meter: &mut Meter,
        watch: &mut impl FnMut(&State),
    ) -> Result<State, SolveError> {
        let rates = |x: f64, u: f64, f: f64, drive: f64| {
            let slip = self.sliding + u;
            (drive - self.stiffness * x - self.damping * u - self.friction * f, slip - slip.abs() * f)
        };
        let (mut x, mut u) = (from.x_m * self.per_m, from.v_m_per_s * self.per_m_per_s);
        let mut f = from.force_n / self.coulomb_n;
        let limit = 10.0 * f.abs().max(1.0);
        let (mut sum, mut steps) = (0.0, 0u32);
        let mut state = *from;
        for (&now, &[middle, end]) in table.iter().step_by(2).zip(table[1..].as_chunks::<2>().0) {
            let (a1, g1) = rates(x, u, f, now);
            let (x2, u2, f2) = (x + 0.5 * u, u + 0.5 * a1, f + 0.5 * g1);
            let (a2, g2) = rates(x2, u2, f2, middle);
            let (x3, u3, f3) = (x + 0.5 * u2, u + 0.5 * a2, f + 0.5 * g2);
            let (a3, g3) = rates(x3, u3, f3, middle);
            let (x4, u4, f4) = (x + u3, u + a3, f + g3);
            let (a4, g4) = rates(x4, u4, f4, end);
            sum += f + 2.0 * (f2 + f3) + f4;
            x += (u + 2.0 * (u2 + u3) + u4) / 6.0;
            u += (a1 + 2.0 * (a2 + a3) + a4) / 6.0;
            f += (g1 + 2.0 * (g2 + g3) + g4) / 6.0;
            steps += 1;
            let time_s = stretch.start_s + f64::from(steps) * self.h;
            // A NaN in x or x' makes f NaN within a step.
            if f.is_nan() || f.abs() > limit {
                return Err(SolveError::Diverged { method: METHOD, time_s });
            }
            state = State { time_s, x_m: x / self.per_m, v_m_per_s: u / self.per_m_per_s, force_n: self.coulomb_n * f };
            watch(&state);
        }
        meter.totals.friction_n_s += sum * self.h / 6.0 * self.coulomb_n;
        meter.totals.felt_n_s = meter.totals.friction_n_s;
        meter.tally.steps += u64::from(steps);
        Ok(state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use contact::table_4_1::table_4_1;
    use contact::tally::Ratios;
    use contact::{Sign, rk4};

    /// Returns the largest difference of x, x' and F from the original method, over the largest of
    /// each, and the difference of the means.
    fn apart(problem: &Problem, steps: u32) -> (f64, f64) {
        let (mut one, mut other) = (Vec::new(), Vec::new());
        let tally = run(problem, steps, &mut |state| one.push(*state)).unwrap();
        let reference = rk4::run(problem, steps, &mut |state| other.push(*state)).unwrap();
        assert_eq!((one.len(), tally.steps), (other.len(), reference.steps));
        let of = |get: fn(&State) -> f64| {
            let largest = other.iter().map(|s| get(s).abs()).fold(0.0, f64::max);
            one.iter().zip(&other).map(|(a, b)| (get(a) - get(b)).abs()).fold(0.0, f64::max) / largest
        };
        let states = of(|s| s.x_m).max(of(|s| s.v_m_per_s)).max(of(|s| s.force_n)).max(of(|s| s.time_s));
        let mean = Ratios::of(problem, &tally).friction - Ratios::of(problem, &reference).friction;
        (states, mean.abs())
    }

    #[test]
    fn steps_equal_rk4_to_round_off() {
        let mut problem = table_4_1(0.5, 200.0);
        if let Motion::Sdof { damping_n_s_per_m, .. } = &mut problem.motion {
            *damping_n_s_per_m = 2.0;
        }
        problem.load_steps = vec![(120.0 / 60e3, 0.5 * problem.coulomb_n)];
        let (states, mean) = apart(&problem, 100);
        println!("passive: {states:e} {mean:e}");
        problem.sign = Sign::Literal;
        let (literal_states, literal_mean) = apart(&problem, 100);
        println!("literal: {literal_states:e} {literal_mean:e}");
        assert!(states < 1e-11 && mean < 1e-11 && literal_states < 1e-11 && literal_mean < 1e-11);
    }

    #[test]
    fn unsupported_problems_are_refused() {
        let mut problem = table_4_1(0.5, 4.0);
        problem.window_s.0 = 1.5 / 60e3;
        assert!(matches!(run(&problem, 10, &mut |_| ()), Err(SolveError::Unsuited { .. })));
        let kinematic = Problem { motion: Motion::Kinematic, ..table_4_1(0.5, 4.0) };
        assert!(matches!(run(&kinematic, 10, &mut |_| ()), Err(SolveError::Unsuited { .. })));
    }
}
