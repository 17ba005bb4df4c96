//! Coulomb friction, solved exactly from event to event.
//!
//! Between reversals of the slip the friction is constant, so the oscillator is linear with a
//! smooth forcing: its Taylor series is the exact flow (`arc`). Reversals are zeros of that
//! polynomial, located to round-off (`crossing`). The steady response `F0 / (Ks - m w^2)` does not
//! occur, so resonance is not a special case.
//!
//! At a reversal (V = 0) the law `F = Fc sgn V` does not determine F; Filippov's solution (1988)
//! does. With the force needed to hold the contact, `R = Fe - c x' - Ks x`:
//!
//! ```text
//! passive:   |R| <= Fc  the contact sticks, F = R, until |R| exceeds Fc;   R > Fc  slips forward;   R < -Fc  backward
//! literal:   R > Fc  slips backward;   R < -Fc  forward;   |R| < Fc  either direction or none: not
//!                                                                    unique, and refused
//! ```
//!
//! With the literal sign, the slip passes through V = 0 whenever it reaches it. Only starts at V =
//! 0 are therefore refused. A given motion has no such ambiguity: friction follows the sign of V,
//! and does not change while V is zero.
//!
//! The steps only determine how often a state is reported; the solution does not depend on them,
//! apart from round-off.

mod arc;
mod crossing;

use crate::SolveError;
use crate::problem::{Law, Motion, Problem, Sign};
use crate::tally::{Meter, State, Tally};
use crate::timeline::{Stretch, Timeline};
use arc::{Arc, TERMS};

const METHOD: &str = "coulomb";

/// Largest phase of forcing or oscillator in a step, rad: twice its power TERMS, over TERMS!, is
/// 3e-17.
const LARGEST_PHASE_RAD: f64 = 0.8;

/// Slip velocity below which a given motion counts as at rest, as a fraction of sliding and
/// vibration velocity.
const STANDSTILL_REL: f64 = 1e-13;

/// Number of events within one step above which the solution counts as diverged.
const MAX_EVENTS_PER_STEP: u32 = 1000;

/// State of the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Contact {
    /// The contact slips in the direction of this sign.
    Slip(f64),
    /// The contact sticks: its slip velocity is zero.
    Stick,
}

/// Runs a problem with a number of steps per period; `watch` receives the state after every step.
pub fn run(problem: &Problem, steps_per_period: u32, watch: &mut dyn FnMut(&State)) -> Result<Tally, SolveError> {
    if problem.law != Law::Coulomb {
        return unsuited("it only solves Coulomb friction, which is constant from reversal to reversal");
    }
    let mut runner = Runner {
        problem,
        coulomb_n: problem.coulomb_n,
        standstill: STANDSTILL_REL * (problem.sliding_m_per_s.abs() + problem.waveform.amplitude().abs()),
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
    /// Number of leading coefficients of the slip velocity that are zero: one after a reversal, two
    /// after sticking.
    zeros: usize,
    meter: Meter,
}

impl Runner<'_> {
    /// Returns the smallest number of steps for which the series converges fast enough.
    fn fewest(&self, stretch: &Stretch) -> u32 {
        let mut rate = std::f64::consts::TAU * stretch.forcing.fastest_hz(stretch.length_s).unwrap_or(0.0);
        if let Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } = self.problem.motion {
            rate = rate.max((stiffness_n_per_m / mass_kg).sqrt() + damping_n_s_per_m.abs() / mass_kg);
        }
        (rate * stretch.length_s / LARGEST_PHASE_RAD).ceil() as u32
    }

    /// Computes one step of `h` seconds, `s` seconds after the beginning of a stretch.
    fn step(&mut self, stretch: &Stretch, s: f64, h: f64, jump: bool) -> Result<(), SolveError> {
        let mut done = 0.0;
        for _ in 0..MAX_EVENTS_PER_STEP {
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

    /// Determines the state of the contact at the beginning of a step.
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
            // At rest: the first non-zero derivative determines the direction.
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

    /// Handles an event: the slip velocity is zero, or friction is at its bound.
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

    /// Applies Filippov's choice at V = 0, for a force on the oscillator.
    fn decide(&mut self, forcing: f64) -> Result<(), SolveError> {
        let Motion::Sdof { stiffness_n_per_m, damping_n_s_per_m, .. } = self.problem.motion else { return Ok(()) };
        let factor = self.problem.sign.factor();
        self.state.v_m_per_s = -factor * self.problem.sliding_m_per_s;
        let needed = forcing - damping_n_s_per_m * self.state.v_m_per_s - stiffness_n_per_m * self.state.x_m;
        self.zeros = 1;
        self.contact = if needed.abs() > self.coulomb_n { Contact::Slip(factor * needed.signum()) } else { Contact::Stick };
        if self.contact == Contact::Stick && self.problem.sign == Sign::Literal {
            return unsuited(
                "with the literal sign, a contact at rest that friction can hold may start in either direction: no unique solution",
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

    /// Returns the fraction of the arc at which it ends early; `None` if it does not.
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

    /// Advances along the fraction `part` of an arc.
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
