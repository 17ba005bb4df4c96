//! ode_solvers: the Runge-Kutta methods of Dormand and Prince, Dopri5 of order five (here) and
//! Dop853 of order eight (`dop853`).
//!
//! The library has no root finding, so it is used in two ways. The simple one has the sign of the
//! slip in the right-hand side. The other holds the sign: the stop function stops it after the step
//! in which the slip reverses, the reversal is located on the continuous output, and the
//! integration restarts there with the step that it had.

use std::time::Instant;

use anyhow::Context;
use ode_solvers::continuous_output_model::ContinuousOutputModel;
use ode_solvers::dop_shared::IntegrationError;
use ode_solvers::{Dopri5, OutputType, SVector, System};

use crate::case::{Case, Kind, LONGEST_FIRST_STEP, LONGEST_STEP};
use crate::dop853;
use crate::peer::{Family, Outcome, Peer, Setting, Way, fine_tolerances, with_longest_steps};
use crate::scaled::{Clock, Scaled};

/// The states x, v, f, q, then phase and frequency of the forcing, used only by the autonomous
/// form.
pub type Y = SVector<f64, 6>;

/// Largest number of steps of a run.
pub const MAX_STEPS: u32 = 200_000_000;
/// Number of steps between tests for stiffness: the library's default.
pub const STIFFNESS_TESTS: u32 = 1000;
/// The library's defaults: safety, beta of the step controller, smallest and largest step ratio.
const CONTROL: [f64; 4] = [0.9, 0.04, 0.2, 10.0];

/// The ode_solvers library.
pub struct OdeSolvers;

const WAYS: [&str; 4] = [
    "Dopri5, located reversals",
    "Dopri5, sgn V in f",
    "Dop853, autonomous, located reversals",
    "Dop853, autonomous, sgn V in f",
];

impl Peer for OdeSolvers {
    fn name(&self) -> String {
        "ode_solvers".into()
    }

    fn family(&self) -> Family {
        Family::Rust
    }

    fn ways(&self, kind: Kind) -> Vec<Way> {
        let ways = WAYS.into_iter().enumerate().map(|(number, name)| Way::new(number, name, fine_tolerances(4, 14)));
        with_longest_steps(kind, ways.collect())
    }

    fn run(&mut self, case: &Case, way: &Way, setting: Setting) -> anyhow::Result<Outcome> {
        let (dopri5, events) = (way.number < 2, way.number.is_multiple_of(2));
        let longest = way.longest.unwrap_or(if events { LONGEST_STEP } else { case.length() });
        let leg = Leg { tolerance: setting.tolerance()?, end: 0.0, step: 0.0, longest };
        let mut contact = Contact {
            scaled: case.scaled,
            clock: Clock::new(&case.scaled),
            sign: events.then_some(1.0),
            stops: events,
            autonomous: !dopri5,
        };
        let began = Instant::now();
        let [middle, end] = match (dopri5, events) {
            (true, true) => from_reversal_to_reversal(leg, &mut contact, case)?,
            (false, true) => dop853::from_reversal_to_reversal(leg, &mut contact, case)?,
            (_, false) => {
                let mut y = at_rest(&contact);
                let mut states = [y; 2];
                for (mark, state) in case.marks().into_iter().zip(&mut states) {
                    let length = contact.clock.until(mark);
                    let leg = Leg { end: length, ..leg };
                    y = if dopri5 { leg.go(&contact, y)?.at(length)? } else { dop853::end(&leg, &contact, y)? };
                    contact.clock.advance(length);
                    *state = y;
                }
                states
            }
        };
        let wall_ns = began.elapsed().as_secs_f64() * 1e9;
        let sign = contact.sign.unwrap_or(contact.scaled.slip(end.as_slice()).signum());
        Ok(Outcome::new(&case.scaled, sign, middle.as_slice(), end.as_slice(), wall_ns))
    }
}

fn from_reversal_to_reversal(mut leg: Leg, contact: &mut Contact, case: &Case) -> anyhow::Result<[Y; 2]> {
    let mut y = at_rest(contact);
    let mut states = [y; 2];
    for (mark, state) in case.marks().into_iter().zip(&mut states) {
        loop {
            leg.end = contact.clock.until(mark);
            let path = leg.go(contact, y)?;
            y = path.at(path.last.1)?;
            if contact.forward(&y) >= 0.0 {
                break;
            }
            let reversal = path.reversal(contact)?;
            y = path.at(reversal)?;
            contact.reverse(reversal, &mut y);
            leg.step = (path.last.1 - path.last.0).min(LONGEST_FIRST_STEP);
        }
        contact.clock.advance(leg.end);
        *state = y;
    }
    Ok(states)
}

/// Returns the state at the beginning, at rest.
pub fn at_rest(contact: &Contact) -> Y {
    let mut y = Y::zeros();
    y[5] = contact.clock.frequency;
    y
}

/// Right-hand side of the equations of motion.
#[derive(Clone, Copy)]
pub struct Contact {
    /// Coefficients of the scaled equations.
    pub scaled: Scaled,
    /// Time at the beginning of the leg.
    pub clock: Clock,
    /// Sign of the slip, if it is held.
    pub sign: Option<f64>,
    /// `true` if an integration stops after the step in which the slip reverses.
    pub stops: bool,
    /// `true` if phase and frequency are states.
    pub autonomous: bool,
}

impl Contact {
    /// Returns the slip in the direction of the held sign: negative after a reversal.
    pub fn forward(&self, y: &Y) -> f64 {
        self.sign.unwrap_or(0.0) * self.scaled.slip(y.as_slice())
    }

    /// Applies a reversal: sets the slip to exactly zero, flips the sign, and begins the next leg.
    pub fn reverse(&mut self, time: f64, y: &mut Y) {
        y[1] = -self.scaled.sliding;
        self.sign = self.sign.map(|sign| -sign);
        self.clock.advance(time);
        (y[4], y[5]) = (self.clock.phase(), self.clock.frequency);
    }
}

impl System<f64, Y> for Contact {
    fn system(&self, time: f64, y: &Y, rates: &mut Y) {
        let phase = if self.autonomous { y[4] } else { self.clock.phase_at(time) };
        match self.sign {
            Some(sign) => self.scaled.held(sign, phase.cos(), y.as_slice(), rates.as_mut_slice()),
            None => self.scaled.free(phase.cos(), y.as_slice(), rates.as_mut_slice()),
        }
        (rates[4], rates[5]) = if self.autonomous { (y[5], self.scaled.rate) } else { (0.0, 0.0) };
    }

    fn solout(&mut self, _time: f64, y: &Y, _rates: &Y) -> bool {
        self.stops && self.forward(y) < 0.0
    }
}

/// One integration, with a clock that starts at zero.
#[derive(Clone, Copy)]
pub struct Leg {
    /// Absolute and relative tolerance.
    pub tolerance: f64,
    /// End of the leg, unless a reversal ends it earlier.
    pub end: f64,
    /// First step; zero leaves it to the method.
    pub step: f64,
    /// Longest step.
    pub longest: f64,
}

impl Leg {
    fn go(&self, contact: &Contact, y: Y) -> Result<Path, IntegrationError> {
        let Leg { tolerance, end, step, longest } = *self;
        let [safety, beta, least, largest] = CONTROL;
        let kind = OutputType::Continuous;
        let mut method = Dopri5::from_param(
            *contact,
            0.0,
            end,
            0.0,
            y,
            tolerance,
            tolerance,
            safety,
            beta,
            least,
            largest,
            longest,
            step,
            MAX_STEPS,
            STIFFNESS_TESTS,
            kind,
        );
        let mut output = ContinuousOutputModel::default();
        method.integrate_with_continuous_output_model(&mut output)?;
        let ends = method.x_out();
        let before = ends.len().checked_sub(2).map_or(0.0, |index| ends[index]);
        Ok(Path { output, last: (before, ends.last().copied().unwrap_or(0.0)) })
    }
}

/// Continuous output of an integration.
struct Path {
    output: ContinuousOutputModel<f64, Y>,
    /// Beginning and end of its last step.
    last: (f64, f64),
}

impl Path {
    fn at(&self, time: f64) -> anyhow::Result<Y> {
        // The last step may end a few units in the last place before the requested end.
        self.output.evaluate(time.min(self.last.1)).context("ode_solvers has no output there")
    }

    /// Returns the time of the reversal within the last step, by bisection.
    fn reversal(&self, contact: &Contact) -> anyhow::Result<f64> {
        let (mut before, mut after) = self.last;
        loop {
            let half = 0.5 * (before + after);
            if half <= before || half >= after {
                return Ok(after);
            }
            if contact.forward(&self.at(half)?) < 0.0 { after = half } else { before = half }
        }
    }
}
