//! Coulomb friction, exactly, from event to event.
//!
//! Between reversals of the slip the friction is constant, so that the oscillator is linear with a smooth forcing: its Taylor series is
//! the exact flow (`arc`). Reversals are zeros of that polynomial, located to round-off (`crossing`). Nowhere is the response at
//! resonance divided by what vanishes there: `F0 / (Ks - m w^2)` does not occur.
//!
//! At a reversal (V = 0) the law `F = Fc sgn V` leaves F open, and Filippov's solution (1988) closes it. With the force needed to hold
//! the contact, `R = Fe - c x' - Ks x`:
//!
//! ```text
//! passive:   |R| <= Fc  the contact sticks, F = R, until |R| exceeds Fc;   R > Fc  slips forward;   R < -Fc  backward
//! literal:   R > Fc  slips backward;   R < -Fc  forward;   |R| < Fc  both ways and none: there is no unique solution, and it is refused
//! ```
//!
//! The literal sign comes to V = 0 only where it passes on, so that it is refused for starts at V = 0 alone. A given motion has no
//! such choice: there friction follows the sign of V, and stays as it was while V is zero.
//!
//! Steps only say how often a state is handed over; the answer does not depend on them, beyond round-off.

mod arc;
mod crossing;

use crate::SolveError;
use crate::problem::{Law, Motion, Problem, Sign};
use crate::tally::{Meter, State, Tally};
use crate::timeline::{Stretch, Timeline};
use arc::{Arc, TERMS};

const METHOD: &str = "coulomb";

/// Largest phase of forcing or oscillator in a step, rad: twice this to the power TERMS over TERMS! is 3e-17.
const LARGEST_RAD: f64 = 0.8;

/// A given slip velocity this small a part of sliding and vibration is none.
const STANDSTILL: f64 = 1e-13;

/// Events within one step above which something is wrong.
const MANY: u32 = 1000;

/// What the contact does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Contact {
    /// Slips, in this direction.
    Slip(f64),
    /// The contact sticks: its slip velocity is zero.
    Stick,
}

/// Runs a problem with so many steps a period; `watch` sees the state after every step.
pub fn run(problem: &Problem, steps_per_period: u32, watch: &mut impl FnMut(&State)) -> Result<Tally, SolveError> {
    if problem.law != Law::Coulomb {
        return unsuited("it is for Coulomb friction, which is constant from reversal to reversal");
    }
    let mut runner = Runner {
        problem,
        coulomb_n: problem.coulomb_n,
        standstill: STANDSTILL * (problem.sliding_m_per_s.abs() + problem.waveform.amplitude().abs()),
        state: problem.start,
        contact: Contact::Stick,
        zeros: 0,
        meter: Meter::new(true),
    };
    let first_slip = problem.sliding_m_per_s + problem.sign.factor() * problem.start.v_m_per_s;
    if first_slip != 0.0 && problem.motion != Motion::Kinematic {
        runner.contact = Contact::Slip(first_slip.signum());
    }
    for stretch in Timeline::new(problem) {
        if let Some(force) = stretch.load {
            runner.coulomb_n = force;
        }
        runner.meter.at(&stretch, &runner.state, runner.coulomb_n);
        let steps = stretch.steps(steps_per_period).max(runner.fewest(&stretch));
        let h = stretch.length_s / f64::from(steps);
        for step in 0..steps {
            runner.step(&stretch, f64::from(step) * h, h, step == 0)?;
            runner.state.time_s = stretch.start_s + f64::from(step + 1) * h;
            runner.meter.step(&runner.state, runner.state.force_n / runner.coulomb_n);
            watch(&runner.state);
        }
    }
    Ok(runner.meter.finish(&runner.state, runner.coulomb_n))
}

fn unsuited<T>(reason: &str) -> Result<T, SolveError> {
    Err(SolveError::Unsuited { method: METHOD, reason: reason.to_owned() })
}

struct Runner<'a> {
    problem: &'a Problem,
    coulomb_n: f64,
    standstill: f64,
    state: State,
    contact: Contact,
    /// How many leading coefficients of the slip velocity are zero: one after a reversal, two after sticking.
    zeros: usize,
    meter: Meter,
}

impl Runner<'_> {
    /// Steps that keep the series short.
    fn fewest(&self, stretch: &Stretch) -> u32 {
        let mut rate = std::f64::consts::TAU * stretch.forcing.fastest_hz(stretch.length_s).unwrap_or(0.0);
        if let Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } = self.problem.motion {
            rate = rate.max((stiffness_n_per_m / mass_kg).sqrt() + damping_n_s_per_m.abs() / mass_kg);
        }
        (rate * stretch.length_s / LARGEST_RAD).ceil() as u32
    }

    /// One step of `h` seconds, `s` seconds into a stretch.
    fn step(&mut self, stretch: &Stretch, s: f64, h: f64, jump: bool) -> Result<(), SolveError> {
        let mut done = 0.0;
        for _ in 0..MANY {
            let length = h - done;
            let forcing = arc::scaled(stretch.forcing.taylor::<TERMS>(s + done), length);
            if done == 0.0 {
                self.begin(&forcing, jump)?;
            }
            let arc = self.arc(&forcing, length);
            let until = self.event(&arc);
            self.advance(&arc, until.unwrap_or(1.0));
            if !(self.state.x_m.is_finite() && self.state.v_m_per_s.is_finite()) {
                return Err(SolveError::Diverged { method: METHOD, time_s: stretch.start_s + s });
            }
            let Some(until) = until else { return Ok(()) };
            done = (done + until * length).min(h);
            self.turn(stretch.forcing.value(s + done))?;
        }
        Err(SolveError::Diverged { method: METHOD, time_s: stretch.start_s + s })
    }

    /// What the contact does at the beginning of a step.
    fn begin(&mut self, forcing: &[f64; TERMS], jump: bool) -> Result<(), SolveError> {
        self.zeros = 0;
        if self.problem.motion == Motion::Kinematic {
            let slip = self.slip_of(forcing[0]);
            if slip.abs() > self.standstill {
                if jump || self.contact == Contact::Stick {
                    self.contact = Contact::Slip(slip.signum());
                }
                return Ok(());
            }
            // At a standstill: it goes where the first derivative points that is not zero.
            let factor = self.problem.sign.factor();
            let direction = forcing.iter().enumerate().skip(1).find(|(_, c)| c.abs() > self.standstill);
            self.zeros = direction.map_or(1, |(order, _)| order);
            let next = direction.map_or(Contact::Stick, |(_, c)| Contact::Slip((factor * c).signum()));
            if !jump && matches!((self.contact, next), (Contact::Slip(before), Contact::Slip(after)) if before != after) {
                self.meter.tally.reversals += 1;
            }
            self.contact = next;
            return Ok(());
        }
        let slip = self.slip_of(self.state.v_m_per_s);
        match self.contact {
            Contact::Slip(sign) if sign * slip > 0.0 => Ok(()),
            _ => self.decide(forcing[0]),
        }
    }

    /// An event has been reached: the slip velocity is zero, or friction at its bound.
    fn turn(&mut self, forcing: f64) -> Result<(), SolveError> {
        match (self.contact, self.problem.motion) {
            (Contact::Slip(sign), Motion::Kinematic) => {
                self.meter.tally.reversals += 1;
                (self.contact, self.zeros) = (Contact::Slip(-sign), 1);
            }
            (Contact::Slip(_), _) => {
                self.meter.tally.reversals += 1;
                self.decide(forcing)?;
            }
            (Contact::Stick, _) => (self.contact, self.zeros) = (Contact::Slip(self.state.force_n.signum()), 2),
        }
        Ok(())
    }

    /// Filippov's choice at V = 0, for a force on the oscillator.
    fn decide(&mut self, forcing: f64) -> Result<(), SolveError> {
        let Motion::Sdof { stiffness_n_per_m, damping_n_s_per_m, .. } = self.problem.motion else { return Ok(()) };
        let factor = self.problem.sign.factor();
        self.state.v_m_per_s = -factor * self.problem.sliding_m_per_s;
        let needed = forcing - damping_n_s_per_m * self.state.v_m_per_s - stiffness_n_per_m * self.state.x_m;
        self.zeros = 1;
        self.contact = if needed.abs() > self.coulomb_n { Contact::Slip(factor * needed.signum()) } else { Contact::Stick };
        if self.contact == Contact::Stick && self.problem.sign == Sign::Literal {
            return unsuited(
                "with the literal sign a contact without slip that friction could hold may start either way: no unique solution",
            );
        }
        Ok(())
    }

    fn slip_of(&self, v: f64) -> f64 {
        self.problem.sliding_m_per_s + self.problem.sign.factor() * v
    }

    fn arc(&self, forcing: &[f64; TERMS], length: f64) -> Arc {
        match (self.problem.motion, self.contact) {
            (Motion::Kinematic, Contact::Slip(sign)) => Arc::given(forcing, length, &self.state, sign * self.coulomb_n),
            (Motion::Kinematic, Contact::Stick) => {
                Arc::given(forcing, length, &self.state, self.state.force_n.clamp(-self.coulomb_n, self.coulomb_n))
            }
            (motion, Contact::Slip(sign)) => Arc::free(motion, forcing, length, &self.state, sign * self.coulomb_n),
            (motion, Contact::Stick) => Arc::held(motion, forcing, length, &self.state),
        }
    }

    /// When the arc ends before its time, as a part of it.
    fn event(&self, arc: &Arc) -> Option<f64> {
        match self.contact {
            Contact::Slip(sign) => {
                let factor = self.problem.sign.factor();
                let mut slip = arc.velocity.map(|c| sign * factor * c);
                slip[0] += sign * self.problem.sliding_m_per_s;
                crossing::first(&slip, self.zeros)
            }
            Contact::Stick if self.problem.motion == Motion::Kinematic => None,
            Contact::Stick => {
                let to_bound = |side: f64| {
                    let mut left = arc.friction.map(|c| -side * c);
                    left[0] += self.coulomb_n;
                    crossing::first(&left, usize::from(left[0] <= 0.0))
                };
                match (to_bound(1.0), to_bound(-1.0)) {
                    (Some(upper), Some(lower)) => Some(upper.min(lower)),
                    (upper, lower) => upper.or(lower),
                }
            }
        }
    }

    /// Goes along an arc, as far as `part` of it.
    fn advance(&mut self, arc: &Arc, part: f64) {
        let before = self.state.x_m;
        (self.state.x_m, self.state.v_m_per_s, self.state.force_n) = arc.at(part);
        let totals = &mut self.meter.totals;
        let impulse = arc.impulse(part);
        let moved = self.state.x_m - before;
        let force = self.state.force_n;
        if let Contact::Slip(_) = self.contact {
            let slip = self.problem.sliding_m_per_s * part * arc.length + self.problem.sign.factor() * moved;
            totals.friction_work_j += force * slip;
            totals.felt_work_j += force * slip;
        }
        totals.friction_n_s += impulse;
        totals.felt_n_s += impulse;
        match self.problem.motion {
            Motion::Kinematic => totals.input_j += force * moved,
            Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } => {
                let speed_squared = arc.length * arc::product(&arc.velocity, &arc.velocity, part);
                totals.input_j += arc.length * arc::product(&arc.forcing, &arc.velocity, part);
                totals.damping_j += damping_n_s_per_m * speed_squared;
                totals.kinetic_j_s += 0.5 * mass_kg * speed_squared;
                totals.potential_j_s += 0.5 * stiffness_n_per_m * arc.length * arc::product(&arc.place, &arc.place, part);
            }
        }
    }
}

#[cfg(test)]
mod tests;
