//! ode_solvers: the Runge-Kutta method of Dormand and Prince of order eight.
//!
//! Two of its nodes are wrong in version 0.6.2: c12 = c13 = 0, but the row sums of its own
//! coefficients are 1 (github.com/srenevey/ode-solvers, pull request 42). A right-hand side that
//! depends on time is therefore sampled at the wrong moment in every step, at any tolerance. Here
//! it integrates the autonomous form, in which phase and frequency are states; the wrong nodes do
//! not affect that.
//!
//! It has neither root finding nor continuous output. Its stop function stops it after each
//! reversal. A cubic gives a first guess of the reversal; integration up to the guess and Newton's
//! method refine it.

use anyhow::Context;
use ode_solvers::dop_shared::IntegrationError;
use ode_solvers::{Dop853, OutputType, System};

use crate::case::{Case, LONGEST_FIRST_STEP};
use crate::ode_solvers_peer::{Contact, Leg, MAX_STEPS, STIFFNESS_TESTS, Y, at_rest};

/// The library's defaults: safety, beta of the step controller, smallest and largest step ratio.
const CONTROL: [f64; 4] = [0.9, 0.0, 0.333, 6.0];
/// Number of Newton corrections after the guess at a reversal.
const CORRECTIONS: u32 = 2;

/// Integrates from reversal to reversal, and returns the states at the marks.
pub fn from_reversal_to_reversal(mut leg: Leg, contact: &mut Contact, case: &Case) -> anyhow::Result<[Y; 2]> {
    let mut y = at_rest(contact);
    let mut states = [y; 2];
    for (mark, state) in case.marks().into_iter().zip(&mut states) {
        loop {
            leg.end = contact.clock.until(mark);
            let path = go(&leg, contact, y)?;
            let [.., before, after] = &path[..] else { anyhow::bail!("no step was taken") };
            if contact.forward(&after.1) >= 0.0 {
                y = after.1;
                break;
            }
            let (reversal, there) = reach_reversal(contact, leg.tolerance, before, after)?;
            y = there;
            contact.reverse(reversal, &mut y);
            let longest = path.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(0.0, f64::max);
            leg.step = longest.min(LONGEST_FIRST_STEP);
        }
        contact.clock.advance(leg.end);
        *state = y;
    }
    Ok(states)
}

/// Returns the state at the end of a leg.
pub fn end(leg: &Leg, contact: &Contact, y: Y) -> anyhow::Result<Y> {
    Ok(go(leg, contact, y)?.last().context("no step was taken")?.1)
}

/// Returns the time and the state of the reversal within a step.
fn reach_reversal(contact: &Contact, tolerance: f64, before: &(f64, Y), after: &(f64, Y)) -> anyhow::Result<(f64, Y)> {
    let rate = |y: &Y| {
        let mut rates = Y::zeros();
        contact.system(0.0, y, &mut rates);
        contact.sign.unwrap_or(0.0) * rates[1]
    };
    let from = |(start, y): (f64, Y), to: f64| -> anyhow::Result<(f64, Y)> {
        let length = to - start;
        let leg = Leg { tolerance, end: length, step: length, longest: length.abs() };
        Ok((to, end(&leg, &Contact { stops: false, ..*contact }, y)?))
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

/// Returns the downward zero of the cubic with these values and slopes at its ends.
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

/// Integrates a leg, and returns the times and states of its steps.
fn go(leg: &Leg, contact: &Contact, y: Y) -> Result<Vec<(f64, Y)>, IntegrationError> {
    let Leg { tolerance, end, step, longest } = *leg;
    let [safety, beta, least, largest] = CONTROL;
    let mut method = Dop853::from_param(
        *contact,
        0.0,
        end,
        end,
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
        OutputType::Sparse,
    );
    method.integrate()?;
    Ok(method.x_out().iter().copied().zip(method.y_out().iter().copied()).collect())
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
