//! diffsol: Runge-Kutta of Tsitouras, backward differences, and a diagonally implicit method, with its own root finding.
//!
//! At a root the state goes back to it, the held sign flips, the slip is set to zero exactly, and the rates are computed again, since the
//! method reuses them. Whole turns are then taken off the clock: the root finder's own tolerance grows with the time.

use std::cell::Cell;
use std::f64::consts::TAU;
use std::time::Instant;

use diffsol::{
    DiffsolError, NalgebraLU, NalgebraMat, NalgebraVec, OdeBuilder, OdeEquations, OdeSolverMethod, OdeSolverStopReason, Vector,
    VectorCommon,
};

use crate::case::{Case, LONGEST_FIRST_STEP, quarter};
use crate::peer::{Family, Outcome, Peer, Samples, Setting, tolerances};

/// One of its methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Explicit Runge-Kutta method of order five.
    Tsit45,
    /// Backward differences, orders one to five.
    Bdf,
    /// Diagonally implicit, order four.
    Esdirk34,
}

/// The diffsol library with one of its methods.
pub struct Diffsol(pub Method);

impl Peer for Diffsol {
    fn name(&self) -> String {
        let method = match self.0 {
            Method::Tsit45 => "tsit45",
            Method::Bdf => "bdf",
            Method::Esdirk34 => "esdirk34",
        };
        format!("diffsol {method}, events")
    }

    fn family(&self) -> Family {
        Family::Rust
    }

    fn settings(&self) -> Vec<Setting> {
        tolerances()
    }

    fn run(&mut self, case: &Case, setting: Setting) -> anyhow::Result<Outcome> {
        let Setting::Tolerance(tolerance) = setting else { anyhow::bail!("diffsol has no fixed step") };
        let scaled = &case.scaled;
        let sign = Cell::new(1.0);
        let began = Instant::now();
        let problem = OdeBuilder::<NalgebraMat<f64>>::new()
            .rhs_implicit(
                |y, _, t, rates| scaled.held(sign.get(), t.cos(), y, rates),
                |y, _, _, by, out| scaled.jacobian(sign.get(), y, by, out),
            )
            .root(|y, _, _, out| out[0] = scaled.slip(y), 1)
            .init(|_, _, y| y.fill(0.0), 4)
            .rtol(tolerance)
            .atol([tolerance; 4])
            .build()?;
        let samples = match self.0 {
            Method::Tsit45 => follow(&mut problem.tsit45()?, case, &sign)?,
            Method::Bdf => follow(&mut problem.bdf::<NalgebraLU<f64>>()?, case, &sign)?,
            Method::Esdirk34 => follow(&mut problem.esdirk34::<NalgebraLU<f64>>()?, case, &sign)?,
        };
        Ok(samples.outcome(began.elapsed().as_secs_f64() * 1e9))
    }
}

/// Steps a solver from reversal to reversal until all samples are there.
fn follow<'a, Eqn, Solver>(solver: &mut Solver, case: &Case, sign: &Cell<f64>) -> Result<Samples, DiffsolError>
where
    Eqn: OdeEquations<T = f64, V = NalgebraVec<f64>> + 'a,
    Solver: OdeSolverMethod<'a, Eqn>,
{
    let scaled = &case.scaled;
    let mut samples = Samples::new(case);
    let mut turns = 0;
    let mut y = solver.state().y.clone();
    loop {
        let root = match solver.step()? {
            OdeSolverStopReason::RootFound(t, _) => Some(t),
            OdeSolverStopReason::InternalTimestep | OdeSolverStopReason::TstopReached => None,
        };
        let now = root.unwrap_or(solver.state().t);
        loop {
            let Some(next) = samples.next() else { return Ok(samples) };
            let phase = quarter(next - 4 * turns);
            if phase > now {
                break;
            }
            solver.interpolate_inplace(phase, &mut y)?;
            samples.push(y.inner().as_slice());
        }
        if let Some(t) = root {
            solver.state_mut_back(t)?;
            sign.set(-sign.get());
            let state = solver.state_mut();
            state.y[1] = -scaled.sliding;
            scaled.held(sign.get(), t.cos(), state.y.inner().as_slice(), state.dy.inner_mut().as_mut_slice());
            *state.h = state.h.min(LONGEST_FIRST_STEP);
            if t >= TAU {
                *state.t = t - TAU;
                turns += 1;
            }
        }
    }
}
