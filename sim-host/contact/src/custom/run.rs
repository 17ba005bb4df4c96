//! A run from event to event: intervals whose length adapts to the solution, the events that end
//! them, and the sums of the tally.
//! An interval with an event is solved again up to the event, so that none contains a jump.

use super::FrictionLaw;
use super::event::{self, ROUND_OFF_REL};
use super::panel::{Equations, Panel, Point};
use crate::SolveError;
use crate::problem::{Motion, Problem};
use crate::radau::rule;
use crate::tally::{Meter, State, Tally, Totals};
use crate::timeline::{Stretch, Timeline};

const METHOD: &str = "collocation";
/// Power of the length with which the error of a polynomial grows.
const ORDER: f64 = 12.0;
/// Smallest and largest factor between two successive lengths.
const LENGTH_FACTORS: (f64, f64) = (0.2, 3.0);
/// Safety factor of the next length.
const SAFETY: f64 = 0.9;
/// Smallest length of an interval, periods.
const MIN_LENGTH_PERIODS: f64 = 1e-12;
/// Number of events without progress in time at which the law counts as chattering.
const MAX_EVENTS_AT_ONCE: u32 = 16;
/// Minimum number of states per period that an observer receives.
const SEEN_PER_PERIOD: f64 = 96.0;

/// State at the beginning of a run.
#[derive(Clone, Debug)]
pub(super) struct Start {
    /// Internal states.
    pub(super) states: Vec<f64>,
    pub(super) x_m: f64,
    pub(super) v_m_per_s: f64,
    pub(super) switches: Vec<bool>,
}

impl Start {
    pub(super) fn new(problem: &Problem, law: &dyn FrictionLaw) -> Self {
        let start = problem.start;
        Start { states: law.start(), x_m: start.x_m, v_m_per_s: start.v_m_per_s, switches: law.switches() }
    }
}

/// Sums and end of a run.
pub(super) struct Ran {
    pub(super) tally: Tally,
    pub(super) end: Start,
    /// Number of intervals.
    pub(super) intervals: u64,
    /// Number of events.
    pub(super) events: u64,
}

struct Run<'a> {
    equations: Equations<'a>,
    y: Vec<f64>,
    /// Largest error of an interval, relative to the size of each part.
    tolerance: f64,
    period_s: f64,
    /// Length of the next interval, s.
    length_s: f64,
    events_at_once: u32,
    /// Event with which the present interval began.
    turned: Option<usize>,
    intervals: u64,
    events: u64,
}

/// Runs a problem; each interval has at most the error `tolerance`, relative to the largest value
/// of each part of the state so far.
pub(super) fn run(
    problem: &Problem,
    law: &dyn FrictionLaw,
    start: &Start,
    tolerance: f64,
    pause: &dyn Fn(),
    mut watch: Option<&mut dyn FnMut(&State)>,
) -> Result<Ran, SolveError> {
    let mut run = Run::new(problem, law, start, tolerance);
    let mut meter = Meter::new(true);
    let mut state = problem.start;
    for stretch in Timeline::new(problem) {
        if let Some(coulomb_n) = stretch.load {
            run.equations.coulomb_n = coulomb_n;
        }
        run.enter(&stretch);
        state = run.state(&stretch, 0.0);
        meter.at(&stretch, &state, run.equations.coulomb_n);
        let mut at_s = 0.0;
        while at_s < stretch.length_s {
            pause();
            at_s = run.advance(&stretch, at_s, &mut meter, &mut |seen| {
                state = *seen;
                if let Some(watch) = &mut watch {
                    watch(seen);
                }
            })?;
        }
    }
    let tally = meter.finish(&state, run.equations.coulomb_n);
    Ok(Ran { tally, end: run.end(), intervals: run.intervals, events: run.events })
}

impl<'a> Run<'a> {
    fn new(problem: &'a Problem, law: &'a dyn FrictionLaw, start: &Start, tolerance: f64) -> Self {
        let mut y = start.states.clone();
        y.push(start.x_m);
        if problem.motion != Motion::Kinematic {
            y.push(start.v_m_per_s);
        }
        let equations = Equations {
            law,
            problem,
            states: start.states.len(),
            coulomb_n: problem.coulomb_n,
            sign: 1.0,
            switches: start.switches.clone(),
            scale: vec![0.0; y.len()],
        };
        let period_s = 1.0 / problem.waveform.frequency_hz();
        let length_s = period_s / 16.0;
        Run { equations, y, tolerance, period_s, length_s, events_at_once: 0, turned: None, intervals: 0, events: 0 }
    }

    fn end(&self) -> Start {
        let states = self.equations.states;
        Start {
            states: self.y[..states].to_vec(),
            x_m: self.y[states],
            v_m_per_s: self.y.get(states + 1).copied().unwrap_or_default(),
            switches: self.equations.switches.clone(),
        }
    }

    /// Begins a stretch: at a jump of the forcing the slip may have changed its sign.
    fn enter(&mut self, stretch: &Stretch) {
        let forcing = stretch.forcing.value(0.0);
        let margin = self.equations.margins(&self.y, forcing)[0];
        let size = self.equations.problem.sliding_m_per_s.abs() + forcing.abs();
        let speed = if self.equations.problem.motion == Motion::Kinematic { size } else { 0.0 };
        if margin < -ROUND_OFF_REL * speed {
            self.equations.sign = -self.equations.sign;
        }
        self.grow();
    }

    /// Raises the scale of each part to its present size.
    fn grow(&mut self) {
        self.equations.scale.iter_mut().zip(&self.y).for_each(|(scale, y)| *scale = scale.max(y.abs()));
    }

    fn state(&self, stretch: &Stretch, at_s: f64) -> State {
        self.state_of(&self.y, stretch, at_s).0
    }

    fn state_of(&self, y: &[f64], stretch: &Stretch, at_s: f64) -> (State, Point) {
        let mut rates = vec![0.0; y.len()];
        let point = self.equations.point(y, stretch.forcing.value(at_s), &mut rates);
        let x_m = y[self.equations.states];
        (State { time_s: stretch.start_s + at_s, x_m, v_m_per_s: point.v_m_per_s, force_n: point.force_n }, point)
    }

    /// Advances by one interval from `at_s` of a stretch, and returns its end.
    fn advance(
        &mut self,
        stretch: &Stretch,
        at_s: f64,
        meter: &mut Meter,
        seen: &mut dyn FnMut(&State),
    ) -> Result<f64, SolveError> {
        let rest_s = stretch.length_s - at_s;
        let diverged = || SolveError::Diverged { method: METHOD, time_s: stretch.start_s + at_s };
        let (mut length_s, panel) = loop {
            let is_last = self.length_s > (1.0 - 1e-9) * rest_s;
            let length_s = if is_last { rest_s } else { self.length_s };
            let panel = self.equations.solve(&stretch.forcing, (at_s, length_s), &self.y);
            if let Some(panel) = panel {
                let ratio = self.tolerance / panel.error.max(f64::MIN_POSITIVE);
                let factor = (SAFETY * ratio.powf(1.0 / ORDER)).clamp(LENGTH_FACTORS.0, LENGTH_FACTORS.1);
                if ratio >= 1.0 || length_s < self.smallest_s() {
                    // The end of a stretch does not shorten the intervals after it.
                    if !is_last {
                        self.length_s = length_s * factor;
                    }
                    break (length_s, panel);
                }
                self.length_s = length_s * factor.min(SAFETY);
            } else {
                self.length_s = LENGTH_FACTORS.0 * length_s;
            }
            if self.length_s < self.smallest_s() {
                return Err(diverged());
            }
        };
        let event = event::first(&self.equations, &stretch.forcing, (at_s, length_s), &panel, self.turned);
        let panel = match event {
            None => Some(panel),
            Some((part, _)) if part * length_s < self.smallest_s() => None,
            Some((part, _)) => {
                length_s *= part;
                Some(self.equations.solve(&stretch.forcing, (at_s, length_s), &self.y).ok_or_else(diverged)?)
            }
        };
        let mut end_s = at_s;
        if let Some(panel) = panel {
            if !self.take(stretch, (at_s, length_s), &panel, meter, seen) {
                return Err(diverged());
            }
            end_s = if event.is_none() && length_s == rest_s { stretch.length_s } else { at_s + length_s };
            self.events_at_once = 0;
            self.turned = None;
        }
        if let Some((_, which)) = event {
            self.turn(which, meter);
            self.events_at_once += 1;
            if self.events_at_once > MAX_EVENTS_AT_ONCE {
                return Err(SolveError::Unsuited {
                    method: METHOD,
                    reason: format!(
                        "at {:e} s the law jumps to and fro without an end: its force changes its sign with the slip, and no \
                         internal state holds the contact while it sticks",
                        stretch.start_s + at_s
                    ),
                });
            }
        }
        self.grow();
        Ok(end_s)
    }

    fn smallest_s(&self) -> f64 {
        MIN_LENGTH_PERIODS * self.period_s
    }

    /// Carries out an event.
    fn turn(&mut self, which: usize, meter: &mut Meter) {
        self.events += 1;
        self.turned = Some(which);
        match which.checked_sub(1) {
            Some(switch) => self.equations.switches[switch] = !self.equations.switches[switch],
            None => {
                let problem = self.equations.problem;
                if let Some(v) = self.y.get_mut(self.equations.states + 1) {
                    // The slip is exactly zero: its sum cancels without a remainder.
                    *v = -problem.sign.factor() * problem.sliding_m_per_s;
                }
                self.equations.sign = -self.equations.sign;
                meter.tally.reversals += 1;
            }
        }
    }

    /// Takes a solved interval: adds up its integrals, and shows its states. Returns `false` if
    /// its friction is not finite.
    fn take(
        &mut self,
        stretch: &Stretch,
        (from_s, length_s): (f64, f64),
        panel: &Panel,
        meter: &mut Meter,
        seen: &mut dyn FnMut(&State),
    ) -> bool {
        self.intervals += 1;
        let rule = rule();
        let problem = self.equations.problem;
        let mut rates = vec![0.0; self.y.len()];
        for ((y, at), weight) in panel.values[1..].iter().zip(rule.at).zip(rule.weight) {
            let point = self.equations.point(y, stretch.forcing.value(from_s + at * length_s), &mut rates);
            add(&mut meter.totals, problem, (y[self.equations.states], &point), weight * length_s);
            for (scale, y) in self.equations.scale.iter_mut().zip(y) {
                *scale = scale.max(y.abs());
            }
        }
        let gap = self.period_s / SEEN_PER_PERIOD;
        let mut before = 0.0;
        for at in rule.at {
            let parts = ((at - before) * length_s / gap).ceil().max(1.0) as u32;
            for part in 1..=parts {
                let place = if part == parts { at } else { before + (at - before) * f64::from(part) / f64::from(parts) };
                let (state, _) = self.state_of(&panel.value(place), stretch, from_s + place * length_s);
                meter.step(&state, state.force_n / self.equations.coulomb_n);
                seen(&state);
            }
            before = at;
        }
        if let Some(end) = panel.values.last() {
            self.y.clone_from(end);
        }
        meter.totals.friction_n_s.is_finite()
    }
}

/// Adds the forces and powers at one point, over a time.
fn add(totals: &mut Totals, problem: &Problem, (x_m, point): (f64, &Point), time_s: f64) {
    let work = point.force_n * point.slip_m_per_s;
    totals.friction_n_s += time_s * point.force_n;
    totals.friction_work_j += time_s * work;
    totals.felt_n_s += time_s * point.force_n;
    totals.felt_work_j += time_s * work;
    match problem.motion {
        Motion::Kinematic => totals.input_j += time_s * point.force_n * point.v_m_per_s,
        Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } => {
            let square = point.v_m_per_s * point.v_m_per_s;
            totals.input_j += time_s * point.forcing * point.v_m_per_s;
            totals.damping_j += time_s * damping_n_s_per_m * square;
            totals.kinetic_j_s += time_s * 0.5 * mass_kg * square;
            totals.potential_j_s += time_s * 0.5 * stiffness_n_per_m * x_m * x_m;
        }
    }
}
