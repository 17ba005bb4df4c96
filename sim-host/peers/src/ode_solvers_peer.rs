//! ode_solvers: the Runge-Kutta method of Dormand and Prince of order five.
//!
//! The library has no root finding, so it is used in two ways: with the sign of the slip in the right-hand side, as one does first; and
//! with the sign held, stopped by its stop function after the step in which the slip reverses, the reversal found on its continuous
//! output, and started again from there with the step it had.

use std::f64::consts::TAU;
use std::time::Instant;

use anyhow::Context;
use ode_solvers::continuous_output_model::ContinuousOutputModel;
use ode_solvers::dop_shared::IntegrationError;
use ode_solvers::{Dopri5, OutputType, SVector, System};

use crate::case::{Case, LONGEST_FIRST_STEP, LONGEST_STEP, Scaled, quarter};
use crate::peer::{Family, Outcome, Peer, Samples, Setting, tolerances};

/// x, v, f, q, then cosine and sine of the phase, of which only an autonomous form makes use.
pub type Y = SVector<f64, 6>;

/// Steps in a period after which a run is given up.
pub const MOST_STEPS: u32 = 2000;
/// Steps between tests for stiffness: the library's default.
pub const STIFFNESS_TESTS: u32 = 1000;
/// The library's defaults: safety, beta of the controller, smallest and largest change of the step.
const CONTROL: [f64; 4] = [0.9, 0.04, 0.2, 10.0];

/// The peer, by how it treats reversals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dopri5Peer {
    /// Sign in the right-hand side.
    Plain,
    /// From reversal to reversal.
    Events,
}

impl Peer for Dopri5Peer {
    fn name(&self) -> String {
        let way = if *self == Dopri5Peer::Events { "events" } else { "sgn V in f" };
        format!("ode_solvers Dopri5, {way}")
    }

    fn family(&self) -> Family {
        Family::Rust
    }

    fn settings(&self) -> Vec<Setting> {
        tolerances()
    }

    fn run(&mut self, case: &Case, setting: Setting) -> anyhow::Result<Outcome> {
        let Setting::Tolerance(tolerance) = setting else { anyhow::bail!("ode_solvers has no fixed step") };
        let mut samples = Samples::new(case);
        let mut leg = Leg { tolerance, start: 0.0, end: quarter(case.last_quarter()), step: 0.0, most_steps: MOST_STEPS };
        let mut contact = Contact { scaled: case.scaled, sign: None, stops: false, autonomous: false };
        let began = Instant::now();
        match self {
            Dopri5Peer::Plain => {
                leg.most_steps = MOST_STEPS.saturating_mul(case.periods);
                let path = leg.go(contact, at_rest())?;
                while let Some(next) = samples.next() {
                    samples.push(path.at(quarter(next))?.as_slice());
                }
            }
            Dopri5Peer::Events => {
                (contact.sign, contact.stops) = (Some(1.0), true);
                from_reversal_to_reversal(leg, contact, &mut samples)?;
            }
        }
        Ok(samples.outcome(began.elapsed().as_secs_f64() * 1e9))
    }
}

fn from_reversal_to_reversal(mut leg: Leg, mut contact: Contact, samples: &mut Samples) -> anyhow::Result<()> {
    let mut y = at_rest();
    let mut turns = 0;
    loop {
        // Two turns are enough: a reversal comes within one.
        leg.end = leg.start + 2.0 * TAU;
        let path = leg.go(contact, y)?;
        let reversal = path.reversal(&contact)?;
        loop {
            let Some(next) = samples.next() else { return Ok(()) };
            let phase = quarter(next - 4 * turns);
            if phase > reversal {
                break;
            }
            samples.push(path.at(phase)?.as_slice());
        }
        y = path.at(reversal)?;
        contact.reverse(&mut y);
        (leg.start, leg.step) = (reversal, (path.last.1 - path.last.0).min(LONGEST_FIRST_STEP));
        if reversal >= TAU {
            leg.start -= TAU;
            turns += 1;
        }
    }
}

/// State at the beginning, at rest.
pub fn at_rest() -> Y {
    let mut y = Y::zeros();
    y[4] = 1.0;
    y
}

/// Right-hand side of the equations of motion.
#[derive(Clone, Copy)]
pub struct Contact {
    /// Coefficients of the scaled equations.
    pub scaled: Scaled,
    /// The sign of the slip, where it is held.
    pub sign: Option<f64>,
    /// An integration stops after the step in which the slip reverses.
    pub stops: bool,
    /// The cosine is a state.
    pub autonomous: bool,
}

impl Contact {
    /// Slip in the direction of the held sign: negative after a reversal.
    pub fn forward(&self, y: &Y) -> f64 {
        self.sign.unwrap_or(0.0) * self.scaled.slip(y.as_slice())
    }

    /// At a reversal: the slip is zero exactly, and the sign flips.
    pub fn reverse(&mut self, y: &mut Y) {
        y[1] = -self.scaled.sliding;
        self.sign = self.sign.map(|sign| -sign);
    }
}

impl System<f64, Y> for Contact {
    fn system(&self, phase: f64, y: &Y, rates: &mut Y) {
        let cosine = if self.autonomous { y[4] } else { phase.cos() };
        match self.sign {
            Some(sign) => self.scaled.held(sign, cosine, y.as_slice(), rates.as_mut_slice()),
            None => self.scaled.free(cosine, y.as_slice(), rates.as_mut_slice()),
        }
        (rates[4], rates[5]) = if self.autonomous { (-y[5], y[4]) } else { (0.0, 0.0) };
    }

    fn solout(&mut self, _phase: f64, y: &Y, _rates: &Y) -> bool {
        self.stops && self.forward(y) < 0.0
    }
}

/// One integration.
#[derive(Clone, Copy)]
struct Leg {
    tolerance: f64,
    start: f64,
    end: f64,
    /// First step; zero: the method's own choice.
    step: f64,
    most_steps: u32,
}

impl Leg {
    fn go(&self, contact: Contact, y: Y) -> Result<Path, IntegrationError> {
        let Leg { tolerance, start, end, step, most_steps } = *self;
        let [safety, beta, least, largest] = CONTROL;
        let longest = if contact.sign.is_some() { LONGEST_STEP } else { end - start };
        let kind = OutputType::Continuous;
        let mut method = Dopri5::from_param(
            contact,
            start,
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
            most_steps,
            STIFFNESS_TESTS,
            kind,
        );
        let mut output = ContinuousOutputModel::default();
        method.integrate_with_continuous_output_model(&mut output)?;
        let ends = method.x_out();
        let before = ends.len().checked_sub(2).map_or(start, |index| ends[index]);
        Ok(Path { output, last: (before, ends.last().copied().unwrap_or(start)) })
    }
}

/// What an integration went through.
struct Path {
    output: ContinuousOutputModel<f64, Y>,
    /// Beginning and end of its last step.
    last: (f64, f64),
}

impl Path {
    fn at(&self, phase: f64) -> anyhow::Result<Y> {
        // The last step may end a few units in the last place before the end asked for.
        self.output.evaluate(phase.min(self.last.1)).context("ode_solvers has no output there")
    }

    /// The reversal within the last step, by bisection.
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
