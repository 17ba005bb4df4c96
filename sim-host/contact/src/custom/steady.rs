//! Periodic steady state under a law of a user, by shooting.

use super::FrictionLaw;
use super::run::{MIN_INTERVALS_PER_PERIOD, Start, run};
use crate::method::Method;
use crate::orbit::{Orbit, Unsteady};
use crate::problem::{Motion, Problem};
use crate::shooting::{self, Map as _};
use crate::state::State;

/// Tolerance and number of the intervals of the map.
const FINE: (f64, f64) = (1e-11, 2.0 * MIN_INTERVALS_PER_PERIOD);
/// The same by longer intervals; the difference is the error.
const COARSE: (f64, f64) = (1e-10, MIN_INTERVALS_PER_PERIOD);
/// Numbers of periods from the start that give the first guess and the scale. A switch may need
/// long to reach its position.
const FIRST_PERIODS: [f64; 3] = [4.0, 64.0, 512.0];
/// Distance of a multiplier from one that the differences of the map can show.
const MIN_DECAY: f64 = 1e-4;

struct Map<'a> {
    period: Problem,
    law: &'a dyn FrictionLaw,
    switches: Vec<bool>,
    scale: Vec<f64>,
    setting: (f64, f64),
    pause: &'a dyn Fn(),
}

/// Finds the steady state of a problem, and the state at the beginning of its period.
pub(super) fn find(problem: &Problem, law: &dyn FrictionLaw, pause: &dyn Fn()) -> Result<(Orbit, Start), Unsteady> {
    if !problem.waveform.is_periodic() || !problem.load_steps.is_empty() {
        return Err(Unsteady::Aperiodic);
    }
    let mut found = Err(Unsteady::NotFound);
    for periods in FIRST_PERIODS {
        found = find_after(problem, law, periods, pause);
        if found != Err(Unsteady::NotFound) {
            break;
        }
    }
    found
}

/// Finds the steady state from the state after some periods.
fn find_after(problem: &Problem, law: &dyn FrictionLaw, periods: f64, pause: &dyn Fn()) -> Result<(Orbit, Start), Unsteady> {
    let period_s = 1.0 / problem.waveform.frequency_hz();
    let first = Problem { window_s: (0.0, periods * period_s), duration_s: periods * period_s, ..problem.clone() };
    let mut most = Largest::default();
    let ran = run(&first, law, &Start::new(problem, law), COARSE, pause, Some(&mut |state| most.take(state)));
    let ran = ran.map_err(|_| Unsteady::NotFound)?;
    let period = Problem { window_s: (0.0, period_s), duration_s: period_s, ..problem.clone() };
    let moves = problem.motion != Motion::Kinematic;
    // A state that is zero now may not be small; a unit of its own start or change serves it.
    let later = run(&period, law, &ran.end, COARSE, pause, None).map_err(|_| Unsteady::NotFound)?;
    let sizes = ran.end.states.iter().zip(&later.end.states).zip(law.start());
    let mut scale: Vec<f64> =
        sizes.map(|((one, other), start)| one.abs().max(other.abs()).max(start.abs()).max(f64::MIN_POSITIVE.sqrt())).collect();
    if moves {
        scale.extend([most.x_m, most.v_m_per_s].map(|size| size.max(f64::MIN_POSITIVE.sqrt())));
    }
    let map = Map { period, law, switches: ran.end.switches.clone(), scale, setting: FINE, pause };
    let fixed = shooting::find(&map, map.parts(&ran.end))?;
    let coarse = Map { setting: COARSE, scale: map.scale.clone(), switches: map.switches.clone(), ..map };
    let (_, mean) = coarse.advance(&fixed.at).ok_or(Unsteady::NotFound)?;
    let start = coarse.start(&fixed.at);
    let orbit = Orbit {
        start: State { time_s: 0.0, x_m: start.x_m, v_m_per_s: start.v_m_per_s, force_n: 0.0 },
        residual: fixed.residual,
        multiplier: fixed.multiplier,
        error: (mean - fixed.mean).abs(),
        method: Method::Collocation,
        setting: (0, None),
    };
    Ok((orbit, start))
}

/// Largest displacement and velocity of a run.
#[derive(Default)]
struct Largest {
    x_m: f64,
    v_m_per_s: f64,
}

impl Largest {
    fn take(&mut self, state: &State) {
        (self.x_m, self.v_m_per_s) = (self.x_m.max(state.x_m.abs()), self.v_m_per_s.max(state.v_m_per_s.abs()));
    }
}

impl Map<'_> {
    /// Returns a state in units of the scale; a given motion is not a part of it.
    fn parts(&self, start: &Start) -> Vec<f64> {
        let all = start.states.iter().copied().chain([start.x_m, start.v_m_per_s]);
        all.zip(&self.scale).map(|(value, scale)| value / scale).collect()
    }

    fn start(&self, at: &[f64]) -> Start {
        let mut values: Vec<f64> = at.iter().zip(&self.scale).map(|(part, scale)| part * scale).collect();
        let motion = if self.period.motion == Motion::Kinematic { vec![0.0; 2] } else { values.split_off(values.len() - 2) };
        Start { states: values, x_m: motion[0], v_m_per_s: motion[1], switches: self.switches.clone() }
    }
}

impl shooting::Map for Map<'_> {
    fn is_free(&self, _part: usize) -> bool {
        true
    }

    fn min_decay(&self) -> f64 {
        MIN_DECAY
    }

    fn advance(&self, at: &[f64]) -> Option<(Vec<f64>, f64)> {
        let ran = run(&self.period, self.law, &self.start(at), self.setting, self.pause, None).ok()?;
        let mean = ran.tally.totals.friction_n_s / (ran.tally.coulomb_n * ran.tally.time_s);
        let after = self.parts(&ran.end);
        (ran.end.switches == self.switches && after.iter().all(|part| part.is_finite())).then_some((after, mean))
    }
}
