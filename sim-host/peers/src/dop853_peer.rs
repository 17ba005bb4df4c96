//! ode_solvers: the Runge-Kutta method of Dormand and Prince of order eight.
//!
//! Two of its nodes are wrong in version 0.6.2: c12 = c13 = 0, where the row sums of its own coefficients are 1
//! (github.com/srenevey/ode-solvers, pull request 42). A right-hand side with time in it is therefore sampled at the wrong moment in every
//! step. It is run as it is, to show what happens; and in autonomous form, the cosine of the phase being a state, which does not notice.
//!
//! It has neither root finding nor a continuous output. From reversal to reversal it is stopped by its stop function; the reversal is
//! guessed by a cubic and reached by integrating up to the guess and on by Newton's method; quarter periods end its legs.

use std::time::Instant;

use anyhow::{Context, ensure};
use ode_solvers::dop_shared::IntegrationError;
use ode_solvers::{Dop853, OutputType, System};

use crate::case::{Case, quarter};
use crate::ode_solvers_peer::{Contact, MOST_STEPS, STIFFNESS_TESTS, Y, at_rest};
use crate::peer::{Family, Outcome, Peer, Samples, Setting, tolerances};

/// The library's defaults: safety, beta of the controller, smallest and largest change of the step.
const CONTROL: [f64; 4] = [0.9, 0.0, 0.333, 6.0];
/// Corrections after the guess at a reversal.
const CORRECTIONS: u32 = 2;
/// Cosine and sine at quarter periods.
const PHASORS: [(f64, f64); 4] = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];

/// The peer, by how it is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dop853Peer {
    /// As one writes it down: cos t and sgn V in the right-hand side.
    Plain,
    /// The phase as states, the sign in the right-hand side.
    Autonomous,
    /// The phase as states, from reversal to reversal.
    AutonomousEvents,
}

impl Peer for Dop853Peer {
    fn name(&self) -> String {
        let way = match self {
            Dop853Peer::Plain => "sgn V in f",
            Dop853Peer::Autonomous => "autonomous, sgn V in f",
            Dop853Peer::AutonomousEvents => "autonomous, events",
        };
        format!("ode_solvers Dop853, {way}")
    }

    fn family(&self) -> Family {
        Family::Rust
    }

    fn settings(&self) -> Vec<Setting> {
        tolerances()
    }

    fn run(&mut self, case: &Case, setting: Setting) -> anyhow::Result<Outcome> {
        let Setting::Tolerance(tolerance) = setting else { anyhow::bail!("ode_solvers has no fixed step") };
        let sign = (*self == Dop853Peer::AutonomousEvents).then_some(1.0);
        let mut contact = Contact { scaled: case.scaled, sign, stops: sign.is_some(), autonomous: *self != Dop853Peer::Plain };
        let mut samples = Samples::new(case);
        let began = Instant::now();
        if contact.sign.is_some() {
            from_quarter_to_quarter(&mut contact, tolerance, &mut samples)?;
        } else {
            // Its dense output at the very end is extrapolated from the first step that has no other point left to give.
            let leg = Leg { tolerance, length: quarter(case.last_quarter() + 1), step: 0.0 };
            let most_steps = MOST_STEPS.saturating_mul(case.periods);
            let path = leg.go(contact, at_rest(), most_steps, OutputType::Dense)?;
            let found = path.len();
            ensure!(found > case.last_quarter() as usize, "its dense output ended after {found} quarter periods");
            while let Some(next) = samples.next() {
                samples.push(path[next as usize].1.as_slice());
            }
        }
        Ok(samples.outcome(began.elapsed().as_secs_f64() * 1e9))
    }
}

fn from_quarter_to_quarter(contact: &mut Contact, tolerance: f64, samples: &mut Samples) -> anyhow::Result<()> {
    let mut y = at_rest();
    // An autonomous form has no clock: every leg begins at zero.
    let (mut length, mut step) = (quarter(1), 0.0);
    while samples.next().is_some() {
        let leg = Leg { tolerance, length, step };
        let path = leg.go(*contact, y, MOST_STEPS, OutputType::Sparse)?;
        let [.., before, after] = &path[..] else { anyhow::bail!("no step was taken") };
        // A leg of one step says nothing on how long the step might be.
        let longest = path.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(0.0, f64::max);
        step = if path.len() == 2 { quarter(1) } else { longest };
        if contact.forward(&after.1) < 0.0 {
            let (reversal, there) = reach_reversal(contact, tolerance, before, after)?;
            y = there;
            contact.reverse(&mut y);
            length -= reversal;
        } else {
            y = after.1;
            length = quarter(1);
            samples.push(y.as_slice());
            // Where the phase is known, its states need not keep their errors.
            (y[4], y[5]) = PHASORS[samples.next().map_or(0, |next| next as usize - 1) % 4];
        }
    }
    Ok(())
}

/// The reversal within a step: its moment, and the state there.
fn reach_reversal(contact: &Contact, tolerance: f64, before: &(f64, Y), after: &(f64, Y)) -> anyhow::Result<(f64, Y)> {
    let rate = |y: &Y| {
        let mut rates = Y::zeros();
        contact.system(0.0, y, &mut rates);
        contact.sign.unwrap_or(0.0) * rates[1]
    };
    let from = |(start, y): (f64, Y), end: f64| -> anyhow::Result<(f64, Y)> {
        let leg = Leg { tolerance, length: end - start, step: end - start };
        let path = leg.go(Contact { stops: false, ..*contact }, y, MOST_STEPS, OutputType::Sparse)?;
        Ok((end, path.last().context("no step was taken")?.1))
    };
    let guess =
        cubic_root(before.0, after.0, (contact.forward(&before.1), rate(&before.1)), (contact.forward(&after.1), rate(&after.1)));
    let mut here = if guess > before.0 { from(*before, guess)? } else { *before };
    for _ in 0..CORRECTIONS {
        let correction = -contact.forward(&here.1) / rate(&here.1);
        let there = here.0 + correction;
        if there == here.0 {
            break;
        }
        here = from(here, there)?;
    }
    Ok(here)
}

/// Where the cubic with these values and slopes at its ends falls through zero.
fn cubic_root(start: f64, end: f64, first: (f64, f64), last: (f64, f64)) -> f64 {
    let length = end - start;
    let value = |part: f64| {
        let rest = 1.0 - part;
        let ends = first.0 * rest * rest * (1.0 + 2.0 * part) + last.0 * part * part * (3.0 - 2.0 * part);
        ends + length * part * rest * (first.1 * rest - last.1 * part)
    };
    let (mut before, mut after) = (0.0, 1.0);
    for _ in 0..40 {
        let half = 0.5 * (before + after);
        if value(half) < 0.0 { after = half } else { before = half }
    }
    start + length * after
}

/// One integration, from a clock at zero.
#[derive(Clone, Copy)]
struct Leg {
    tolerance: f64,
    length: f64,
    /// First step; zero: the method's own choice.
    step: f64,
}

impl Leg {
    /// Moments and states: of the steps, or a quarter period apart.
    fn go(&self, contact: Contact, y: Y, most_steps: u32, kind: OutputType) -> Result<Vec<(f64, Y)>, IntegrationError> {
        let Leg { tolerance, length, step } = *self;
        let [safety, beta, least, largest] = CONTROL;
        let longest = length.abs();
        let mut method = Dop853::from_param(
            contact,
            0.0,
            length,
            quarter(1),
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
        method.integrate()?;
        Ok(method.x_out().iter().copied().zip(method.y_out().iter().copied()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_its_own_interpolant() {
        // (1 - t)(2 + t)(3 + t) between 0.5 and 1.2
        let value = |t: f64| (1.0 - t) * (2.0 + t) * (3.0 + t);
        let slope = |t: f64| -(2.0 + t) * (3.0 + t) + (1.0 - t) * (5.0 + 2.0 * t);
        let root = cubic_root(0.5, 1.2, (value(0.5), slope(0.5)), (value(1.2), slope(1.2)));
        assert!((root - 1.0).abs() < 1e-11, "{root}");
    }
}
