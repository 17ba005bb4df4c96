//! diffsol: Runge-Kutta of Tsitouras, backward differences, and a diagonally implicit method, with
//! the library's root finding.
//!
//! At a root the state is moved back to it, the held sign flips, the slip is set to exactly zero,
//! and the rates are computed again, because the method reuses them.

use std::cell::Cell;
use std::time::Instant;

use diffsol::{
    DiffsolError, NalgebraLU, NalgebraMat, NalgebraVec, OdeBuilder, OdeEquations, OdeSolverMethod, OdeSolverStopReason, Vector,
    VectorCommon,
};

use crate::case::{Case, Kind, LONGEST_FIRST_STEP};
use crate::peer::{Family, Outcome, Peer, Setting, Way, fine_tolerances};
use crate::scaled::{Clock, Scaled};

/// Methods used: explicit of order five, backward differences of orders one to five, diagonally
/// implicit of order four.
const METHODS: [&str; 3] = ["tsit45", "bdf", "esdirk34"];

/// The diffsol library.
pub struct Diffsol;

impl Peer for Diffsol {
    fn name(&self) -> String {
        "diffsol".into()
    }

    fn family(&self) -> Family {
        Family::Rust
    }

    fn ways(&self, _kind: Kind) -> Vec<Way> {
        let way = |(number, method)| Way::new(number, format!("{method}, located reversals"), fine_tolerances(4, 13));
        METHODS.into_iter().enumerate().map(way).collect()
    }

    fn run(&mut self, case: &Case, way: &Way, setting: Setting) -> anyhow::Result<Outcome> {
        let tolerance = setting.tolerance()?;
        let scaled = &case.scaled;
        let leg = Cell::new((1.0, Clock::new(scaled)));
        let began = Instant::now();
        let problem = OdeBuilder::<NalgebraMat<f64>>::new()
            .rhs_implicit(
                |y, _, t, rates| {
                    let (sign, clock) = leg.get();
                    scaled.held(sign, clock.phase_at(t).cos(), y, rates);
                },
                |y, _, _, by, out| scaled.jacobian(leg.get().0, y, by, out),
            )
            .root(|y, _, _, out| out[0] = scaled.slip(y), 1)
            .init(|_, _, y| y.fill(0.0), 4)
            .rtol(tolerance)
            .atol([tolerance; 4])
            .build()?;
        let [middle, end] = match way.number {
            0 => follow(&mut problem.tsit45()?, case, &leg)?,
            1 => follow(&mut problem.bdf::<NalgebraLU<f64>>()?, case, &leg)?,
            _ => follow(&mut problem.esdirk34::<NalgebraLU<f64>>()?, case, &leg)?,
        };
        let wall_ns = began.elapsed().as_secs_f64() * 1e9;
        Ok(Outcome::new(scaled, leg.get().0, &middle, &end, wall_ns))
    }
}

/// Steps a solver from reversal to reversal, and returns the states at the marks.
fn follow<'a, Eqn, Solver>(solver: &mut Solver, case: &Case, leg: &Cell<(f64, Clock)>) -> Result<[[f64; 4]; 2], DiffsolError>
where
    Eqn: OdeEquations<T = f64, V = NalgebraVec<f64>> + 'a,
    Solver: OdeSolverMethod<'a, Eqn>,
{
    let scaled: &Scaled = &case.scaled;
    let mut y = solver.state().y.clone();
    let mut states = [[0.0; 4]; 2];
    let mut passed = 0;
    loop {
        let root = match solver.step()? {
            OdeSolverStopReason::RootFound(t, _) => Some(t),
            OdeSolverStopReason::InternalTimestep | OdeSolverStopReason::TstopReached => None,
        };
        let now = root.unwrap_or(solver.state().t);
        let (sign, mut clock) = leg.get();
        while clock.until(case.marks()[passed]) <= now {
            solver.interpolate_inplace(clock.until(case.marks()[passed]), &mut y)?;
            states[passed].copy_from_slice(y.inner().as_slice());
            passed += 1;
            if passed == states.len() {
                return Ok(states);
            }
        }
        if let Some(t) = root {
            solver.state_mut_back(t)?;
            clock.advance(t);
            leg.set((-sign, clock));
            let state = solver.state_mut();
            state.y[1] = -scaled.sliding;
            scaled.held(-sign, clock.phase().cos(), state.y.inner().as_slice(), state.dy.inner_mut().as_mut_slice());
            *state.h = state.h.min(LONGEST_FIRST_STEP);
            *state.t = 0.0;
        }
    }
}
