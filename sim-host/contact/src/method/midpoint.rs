//! Exponential midpoint rule, for bristles that are too stiff for Runge-Kutta.
//!
//! The oscillator follows its exact linear flow under the forcing (Simpson's rule) and the step's
//! mean friction. Its slip velocity, a parabola over the step, moves the
//! [`bristle`](super::bristle)s exactly in the slip, reversals included. Friction that follows the
//! slip without delay (sigma1, sigma2, stuck bristles) is implicit. With `F = F* + beta (V - V*)`
//! for the means over the step, and V* predicted with the friction of the last step:
//!
//! ```text
//! V = V(F = 0) - s Bx F / h,   beta = Kt h phi2(L) + sigma1 phi1(L) + sigma2,   phi1 = (1 - e^-L) / L,   phi2 = (1 - phi1) / L
//! ```
//!
//! Bx is the displacement that a unit force causes in a step, adjusted so that a mass under beta
//! alone stops as exp(-beta t / m). The method is bounded at any stiffness and any damping. The
//! coupling is of second order, the friction of a given motion of fourth order, so the error at a
//! weak coupling is small.
//!
//! With sigma1 h / m or sigma2 h / m far above one, the motion and the means remain accurate, but
//! the momentary friction does not: it is then the difference of far larger forces.

use super::bristle::{Bristle, Part, means_left};
use crate::SolveError;
use crate::flow::exponential;
use crate::forcing::Forcing;
use crate::problem::{Law, Motion, Problem};
use crate::tally::{Meter, State, Tally, Totals};
use crate::timeline::Timeline;

const METHOD: &str = "midpoint";

/// Runs a problem with a number of steps per period; `watch` receives the state after every step.
pub fn run(problem: &Problem, steps_per_period: u32, watch: &mut dyn FnMut(&State)) -> Result<Tally, SolveError> {
    let Some(bristle) = Bristle::new(problem.law, problem.coulomb_n) else {
        let reason = "Coulomb friction has no bristles".into();
        return Err(SolveError::Unsuited { method: METHOD, reason });
    };
    let mut walk = Walk::new(problem, bristle);
    let mut meter = Meter::new(true);
    let mut state = problem.start;
    for stretch in Timeline::new(problem) {
        if let Some(force) = stretch.load {
            walk.load(problem.law, force);
        }
        let steps = stretch.steps(steps_per_period);
        let h = stretch.length_s / f64::from(steps);
        walk.enter(&stretch.forcing, h, stretch.start_s == 0.0);
        state = walk.state(stretch.start_s);
        meter.totals = walk.totals;
        meter.at(&stretch, &state, walk.coulomb_n);
        for step in 0..steps {
            walk.step(&stretch.forcing, f64::from(step) * h, h);
            state = walk.state(stretch.start_s + f64::from(step + 1) * h);
            if !(state.force_n.is_finite() && state.x_m.is_finite() && state.v_m_per_s.is_finite()) {
                return Err(SolveError::Diverged { method: METHOD, time_s: state.time_s });
            }
            meter.step(&state, state.force_n / walk.coulomb_n);
            watch(&state);
        }
    }
    (meter.totals, meter.tally.reversals) = (walk.totals, walk.reversals);
    Ok(meter.finish(&state, walk.coulomb_n))
}

/// Exact flow of the oscillator over a step.
#[derive(Clone, Copy, Debug, Default)]
struct Flow {
    h: f64,
    /// Displacement at the end of the step, from x and x' at its beginning.
    x: [f64; 2],
    /// Velocity at the end of the step, from x and x' at its beginning.
    v: [f64; 2],
    /// Change of x and x' from an impulse of 1 N s at the beginning.
    kick: [f64; 2],
    /// Change of x and x' from an impulse of 1 N s in the middle.
    middle_kick: [f64; 2],
    /// Change of x and x' from a constant force of 1 N.
    held: [f64; 2],
}

impl Flow {
    fn over(h: f64, mass: f64, stiffness: f64, damping: f64) -> Self {
        // In the variables x, h x' and h^2 F / m, which are of similar size.
        let of = |part: f64| {
            let t = part * h;
            exponential(&[[0.0, part, 0.0], [-stiffness / mass * h * t, -damping / mass * t, part], [0.0, 0.0, 0.0]])
        };
        let (whole, half) = (of(1.0), of(0.5));
        Flow {
            h,
            x: [whole[0][0], whole[0][1] * h],
            v: [whole[1][0] / h, whole[1][1]],
            kick: [whole[0][1] * h / mass, whole[1][1] / mass],
            middle_kick: [half[0][1] * h / mass, half[1][1] / mass],
            held: [whole[0][2] * h * h / mass, whole[1][2] * h / mass],
        }
    }
}

/// State of a run.
struct Walk {
    motion: Motion,
    /// Sliding speed, m/s.
    sliding: f64,
    /// Factor of x' in the slip.
    sign: f64,
    bristle: Bristle,
    sigma1: f64,
    sigma2: f64,
    coulomb_n: f64,
    x: f64,
    v: f64,
    f: f64,
    /// Present forcing.
    now: f64,
    /// Mean friction of the last step, N.
    force: f64,
    /// Sign of the last slip.
    heading: f64,
    reversals: u64,
    flow: Flow,
    totals: Totals,
}

impl Walk {
    fn new(problem: &Problem, bristle: Bristle) -> Self {
        let (sigma1, sigma2) = if let Law::Lugre { sigma1, sigma2, .. } = problem.law { (sigma1, sigma2) } else { (0.0, 0.0) };
        Walk {
            motion: problem.motion,
            sliding: problem.sliding_m_per_s,
            sign: problem.sign.factor(),
            bristle,
            sigma1,
            sigma2,
            coulomb_n: problem.coulomb_n,
            x: problem.start.x_m,
            v: problem.start.v_m_per_s,
            f: problem.start.force_n / problem.coulomb_n,
            now: 0.0,
            force: 0.0,
            heading: 0.0,
            reversals: 0,
            flow: Flow::default(),
            totals: Totals::default(),
        }
    }

    fn load(&mut self, law: Law, coulomb_n: f64) {
        self.f *= self.coulomb_n / coulomb_n;
        self.coulomb_n = coulomb_n;
        self.bristle = Bristle::new(law, coulomb_n).unwrap_or(self.bristle);
    }

    /// Begins a stretch with steps of `h` seconds.
    fn enter(&mut self, forcing: &Forcing, h: f64, starts: bool) {
        self.now = forcing.value(0.0);
        match self.motion {
            Motion::Kinematic => self.v = self.now,
            Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } => {
                if h != self.flow.h {
                    self.flow = Flow::over(h, mass_kg, stiffness_n_per_m, damping_n_s_per_m);
                }
            }
        }
        if starts {
            self.force = self.state(0.0).force_n;
        }
    }

    fn slip(&self, v: f64) -> f64 {
        self.sliding + self.sign * v
    }

    /// Returns the rate of the bristles' deflection, m/s.
    fn deflecting(&self, f: f64, slip: f64) -> f64 {
        slip - slip.abs() * f / self.bristle.level(slip)
    }

    fn state(&self, time_s: f64) -> State {
        let slip = self.slip(self.v);
        let damped = if self.sigma1 == 0.0 { 0.0 } else { self.sigma1 * self.deflecting(self.f, slip) };
        State { time_s, x_m: self.x, v_m_per_s: self.v, force_n: self.coulomb_n * self.f + damped + self.sigma2 * slip }
    }

    /// Computes one step, `s` seconds after the beginning of the stretch.
    fn step(&mut self, forcing: &Forcing, s: f64, h: f64) {
        let (w0, wm, w1) = (self.now, forcing.value(s + 0.5 * h), forcing.value(s + h));
        self.now = w1;
        let v0 = self.slip(self.v);
        let (x, v) = (self.x, self.v);
        let (slip, part, force) = match self.motion {
            Motion::Kinematic => {
                let slip = [v0, self.slip(wm), self.slip(w1)];
                let part = self.bristle.advance(self.f, h, slip);
                let mean = (slip[0] + 4.0 * slip[1] + slip[2]) / 6.0;
                (self.x, self.v) = (x + h / 6.0 * (w0 + 4.0 * wm + w1), w1);
                (slip, part, self.mean_force(&part, h, mean))
            }
            Motion::Sdof { .. } => self.coupled(h, [w0, wm, w1]),
        };
        self.account(h, [w0, wm, w1], (x, v), slip, &part, force);
        self.f = part.end;
        self.force = force;
        if part.sign != 0.0 {
            self.reversals += u64::from(part.reversals) + u64::from(self.heading * part.first < 0.0);
            self.heading = part.sign;
        }
    }

    fn mean_force(&self, part: &Part, h: f64, slip: f64) -> f64 {
        let bristles = self.coulomb_n * part.impulse / h;
        let damped = self.sigma1 * (part.end - self.f) / (self.bristle.per_m * h);
        bristles + damped + self.sigma2 * slip
    }

    /// Solves oscillator and bristles together. Returns the slip at three times, the effect on the
    /// bristles, and the mean friction.
    fn coupled(&mut self, h: f64, [w0, wm, w1]: [f64; 3]) -> ([f64; 3], Part, f64) {
        let flow = self.flow;
        let free = |start: [f64; 2], i: usize| {
            start[0] * self.x + start[1] * self.v + h / 6.0 * (flow.kick[i] * w0 + 4.0 * flow.middle_kick[i] * wm)
        };
        let free_x = free(flow.x, 0);
        let free_v = free(flow.v, 1) + h / 6.0 * w1 / self.mass();
        let v0 = self.slip(self.v);
        let free_mean = self.slip((free_x - self.x) / h);
        let give = self.sign * flow.held[0] / h;
        let (mut force, mut mean) = (self.force, free_mean - give * self.force);
        let mut rounds = 0;
        loop {
            let v1 = self.slip(free_v - flow.held[1] * force);
            let slip = [v0, 1.5 * mean - 0.25 * (v0 + v1), v1];
            let mut part = self.bristle.advance(self.f, h, slip);
            let foreseen = self.mean_force(&part, h, mean);
            let (phi1, phi2) = means_left(part.length, part.left);
            let beta = self.coulomb_n * self.bristle.per_m * h * phi2 + self.sigma1 * phi1 + self.sigma2;
            let y = 0.5 * self.sign * beta * flow.held[1];
            // 2y / (1 - e^-2y) and its excess over one in units of y
            let excess = if y.abs() < 1e-2 { 1.0 + y / 3.0 } else { (-2.0 * y / (-2.0 * y).exp_m1() - 1.0) / y };
            let free = v0 + excess * (free_mean - v0);
            let now = (free - give * excess * (foreseen - beta * mean)) / (1.0 + give * excess * beta);
            force = foreseen + beta * (now - mean);
            let moved = now - mean;
            part.end = self.bristle.within(self.f, part.end + self.bristle.per_m * h * phi1 * moved);
            mean = now;
            rounds += 1;
            let scale = self.sliding.abs() + v0.abs() + v1.abs();
            if rounds == 8 || moved.abs() <= 1e-7 * scale {
                let (x, v) = (self.x + h * self.sign * (mean - self.sliding), free_v - flow.held[1] * force);
                (self.x, self.v) = (x, v);
                return (slip, part, force);
            }
        }
    }

    fn mass(&self) -> f64 {
        if let Motion::Sdof { mass_kg, .. } = self.motion { mass_kg } else { 1.0 }
    }

    /// Adds a step that began in x and x' to the totals.
    fn account(&mut self, h: f64, w: [f64; 3], (x0, v0): (f64, f64), slip: [f64; 3], part: &Part, force: f64) {
        let simpson = |a: f64, b: f64, c: f64| h / 6.0 * (a + 4.0 * b + c);
        let v1 = self.v;
        let vm = 1.5 * (self.x - x0) / h - 0.25 * (v0 + v1);
        let mut work = self.coulomb_n * part.work;
        if self.sigma1 != 0.0 || self.sigma2 != 0.0 {
            let damped = |f: f64, slip: f64| slip * (self.sigma1 * self.deflecting(f, slip) + self.sigma2 * slip);
            // The middle value that gives the mean by Simpson's rule.
            let middle = 1.5 * part.impulse / h - 0.25 * (self.f + part.end);
            work += simpson(damped(self.f, slip[0]), damped(middle, slip[1]), damped(part.end, slip[2]));
        }
        let mean_slip = self.sliding + self.sign * (self.x - x0) / h;
        let totals = &mut self.totals;
        totals.friction_n_s += force * h;
        totals.friction_work_j += work;
        totals.felt_n_s += force * h;
        totals.felt_work_j += force * mean_slip * h;
        match self.motion {
            Motion::Kinematic => totals.input_j += force * (self.x - x0),
            Motion::Sdof { mass_kg: m, stiffness_n_per_m: k, damping_n_s_per_m: c } => {
                totals.input_j += simpson(w[0] * v0, w[1] * vm, w[2] * v1);
                totals.damping_j += c * simpson(v0 * v0, vm * vm, v1 * v1);
                totals.kinetic_j_s += 0.5 * m * simpson(v0 * v0, vm * vm, v1 * v1);
                let xm = 0.5 * (x0 + self.x) + 0.125 * h * (v0 - v1);
                totals.potential_j_s += 0.5 * k * simpson(x0 * x0, xm * xm, self.x * self.x);
            }
        }
    }
}
