//! A run from event to event: intervals whose length adapts to the solution, the events that end
//! them, and the sums of the tally.
//!
//! An interval with an event is solved again up to the event, so that none contains a jump.

use super::FrictionLaw;
use super::event::{self, Found, ROUND_OFF_REL};
use super::panel::{Equations, Panel, Point};
use crate::SolveError;
use crate::forcing::Forcing;
use crate::problem::{Motion, Problem};
use crate::radau::{STAGES, rule};
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
/// Number of events without progress in time, for each switch and the slip, at which the law counts
/// as chattering.
const MAX_EVENTS_AT_ONCE: u32 = 8;
/// Largest number of attempts to locate an event.
const MAX_LOCATIONS: u32 = 12;
/// Largest number of intervals per period.
const MAX_INTERVALS_PER_PERIOD: f64 = 20_000.0;
/// Part of an interval that counts as its end.
const PART_TOLERANCE: f64 = 1e-9;
/// Number of intervals per period at least, in the coarser run.
pub(super) const MIN_INTERVALS_PER_PERIOD: f64 = 16.0;
/// Minimum number of states per period that an observer receives.
const SEEN_PER_PERIOD: f64 = 96.0;

/// State at the beginning of a run.
#[derive(Clone, Debug, PartialEq)]
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

/// Attempt at an interval.
enum Tried {
    /// Solved, without an event.
    Solved(Panel),
    /// Solved up to a length, s, with the event at its end; no interval, if the event is at once.
    UpTo(f64, Option<Panel>, Option<usize>),
    /// The error is too large: the length to try next, s.
    TooLong(f64),
}

/// Creates the error of a law that is not a number.
fn not_a_number(time_s: f64) -> SolveError {
    let reason = format!("at {time_s:e} s the force, a rate or a condition of the law is not a finite number");
    SolveError::Unsuited { method: METHOD, reason }
}

/// Creates the error of an event that repeats without an end.
fn endless(which: usize, time_s: f64) -> SolveError {
    let why = if which == 0 {
        "its force changes its sign with the slip, and no internal state holds the contact while it sticks"
    } else {
        "the `on` and the `off` of a relay are above zero at once, or the argument of a function with a kink stays at zero"
    };
    SolveError::Unsuited { method: METHOD, reason: format!("at {time_s:e} s the law jumps to and fro without an end: {why}") }
}

/// Observer of the states.
type Seen<'a> = Option<&'a mut dyn FnMut(&State)>;

struct Run<'a> {
    equations: Equations<'a>,
    y: Vec<f64>,
    /// Displacement, m.
    x_m: f64,
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
/// of each part of the state and of the friction so far, and a period has at least `intervals`.
pub(super) fn run(
    problem: &Problem,
    law: &dyn FrictionLaw,
    start: &Start,
    (tolerance, intervals): (f64, f64),
    pause: &dyn Fn(),
    mut watch: Option<&mut dyn FnMut(&State)>,
) -> Result<Ran, SolveError> {
    let mut run = Run::new(problem, law, start, (tolerance, intervals));
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
            at_s = run.advance(&stretch, at_s, &mut meter, &mut watch)?;
        }
        state = run.state(&stretch, stretch.length_s);
    }
    let tally = meter.finish(&state, run.equations.coulomb_n);
    Ok(Ran { tally, end: run.end(), intervals: run.intervals, events: run.events })
}

impl<'a> Run<'a> {
    fn new(problem: &'a Problem, law: &'a dyn FrictionLaw, start: &Start, (tolerance, intervals): (f64, f64)) -> Self {
        let mut y = start.states.clone();
        if problem.motion != Motion::Kinematic {
            y.extend([start.x_m, start.v_m_per_s]);
        }
        let period_s = 1.0 / problem.waveform.frequency_hz();
        let most_s = period_s / intervals;
        let equations = Equations {
            law,
            problem,
            states: start.states.len(),
            coulomb_n: problem.coulomb_n,
            sign: 1.0,
            switches: start.switches.clone(),
            scale: vec![0.0; y.len()],
            largest_n: 0.0,
            most_s,
        };
        Run {
            equations,
            y,
            x_m: start.x_m,
            tolerance,
            period_s,
            length_s: most_s,
            events_at_once: 0,
            turned: None,
            intervals: 0,
            events: 0,
        }
    }

    fn end(&self) -> Start {
        let states = self.equations.states;
        Start {
            states: self.y[..states].to_vec(),
            x_m: self.x_m,
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
        if self.equations.problem.motion == Motion::Kinematic && stands_still(&stretch.forcing, size) {
            self.equations.sign = 0.0;
        } else if self.equations.sign == 0.0 {
            self.equations.sign = 1.0;
            return self.enter(stretch);
        } else if margin < -ROUND_OFF_REL * speed {
            self.equations.sign = -self.equations.sign;
        }
        self.grow();
    }

    /// Raises the scale of each part to its present size.
    fn grow(&mut self) {
        self.equations.scale.iter_mut().zip(&self.y).for_each(|(scale, y)| *scale = scale.max(y.abs()));
    }

    fn state(&self, stretch: &Stretch, at_s: f64) -> State {
        self.state_of(&self.y, self.x_m, stretch, at_s)
    }

    fn state_of(&self, y: &[f64], x_m: f64, stretch: &Stretch, at_s: f64) -> State {
        let mut rates = vec![0.0; y.len()];
        let point = self.equations.point(y, stretch.forcing.value(at_s), &mut rates);
        State { time_s: stretch.start_s + at_s, x_m, v_m_per_s: point.v_m_per_s, force_n: point.force_n }
    }

    /// Advances by one interval from `at_s` of a stretch, and returns its end.
    fn advance(&mut self, stretch: &Stretch, at_s: f64, meter: &mut Meter, seen: &mut Seen) -> Result<f64, SolveError> {
        let rest_s = stretch.length_s - at_s;
        let (length_s, panel, event) = loop {
            let is_last = self.length_s > (1.0 - 1e-9) * rest_s;
            let length_s = if is_last { rest_s } else { self.length_s };
            match self.try_interval(stretch, (at_s, length_s))? {
                Tried::Solved(panel) => {
                    // The end of a stretch does not shorten the intervals after it.
                    if !is_last {
                        self.length_s = length_s * self.factor(panel.error);
                    }
                    break (length_s, Some(panel), None);
                }
                Tried::UpTo(length_s, panel, event) => break (length_s, panel, event),
                Tried::TooLong(shorter_s) => self.length_s = shorter_s,
            }
            self.length_s = self.length_s.min(self.equations.most_s);
            if self.length_s < self.smallest_s() {
                return Err(self.failure(stretch, at_s));
            }
        };
        self.length_s = self.length_s.min(self.equations.most_s);
        let mut end_s = at_s;
        if (self.intervals + self.events) as f64 > MAX_INTERVALS_PER_PERIOD * (1.0 + (stretch.start_s + at_s) / self.period_s) {
            let reason = format!(
                "at {:e} s the law needs more than {MAX_INTERVALS_PER_PERIOD} intervals in a period: it is not smooth between its \
                 events, or too fast",
                stretch.start_s + at_s
            );
            return Err(SolveError::Unsuited { method: METHOD, reason });
        }
        if let Some(panel) = panel {
            if !self.take(stretch, (at_s, length_s), &panel, meter, seen) {
                return Err(not_a_number(stretch.start_s + at_s));
            }
            end_s = if length_s == rest_s { stretch.length_s } else { at_s + length_s };
            self.events_at_once = 0;
            self.turned = None;
        }
        if let Some(which) = event {
            self.turn(which, meter);
            self.events_at_once += 1;
            if self.events_at_once > MAX_EVENTS_AT_ONCE * (1 + self.equations.switches.len() as u32) {
                return Err(endless(which, stretch.start_s + at_s));
            }
        }
        self.grow();
        Ok(end_s)
    }

    /// Returns the reason that no interval succeeds at a moment.
    fn failure(&self, stretch: &Stretch, at_s: f64) -> SolveError {
        let mut rates = vec![0.0; self.y.len()];
        let point = self.equations.point(&self.y, stretch.forcing.value(at_s), &mut rates);
        let time_s = stretch.start_s + at_s;
        if !point.force_n.is_finite() || rates.iter().any(|rate| !rate.is_finite()) {
            return not_a_number(time_s);
        }
        SolveError::Diverged { method: METHOD, time_s }
    }

    /// Tries an interval. With an event in it, the interval is solved again up to the event.
    fn try_interval(&self, stretch: &Stretch, (at_s, length_s): (f64, f64)) -> Result<Tried, SolveError> {
        let mut length_s = length_s;
        let mut located = None;
        for _ in 0..MAX_LOCATIONS {
            let Some(panel) = self.equations.solve(&stretch.forcing, (at_s, length_s), &self.y) else {
                return Ok(Tried::TooLong(LENGTH_FACTORS.0 * length_s));
            };
            match event::first(&self.equations, &stretch.forcing, (at_s, length_s), &panel, self.turned) {
                Found::NotANumber => return Err(not_a_number(stretch.start_s + at_s)),
                Found::Event(part, which) if part * length_s < self.smallest_s() => {
                    return Ok(Tried::UpTo(0.0, None, Some(which)));
                }
                Found::Event(part, which) if part < 1.0 - PART_TOLERANCE => {
                    located = Some(which);
                    length_s *= part;
                    continue;
                }
                Found::Event(_, which) => located = Some(which),
                Found::Nothing => {}
            }
            if panel.error > self.tolerance && length_s > self.smallest_s() {
                return Ok(Tried::TooLong(length_s * self.factor(panel.error).min(SAFETY)));
            }
            let place = (at_s, length_s);
            let is_at_end = |which: &usize| event::is_located(&self.equations, &stretch.forcing, place, &panel, *which);
            return Ok(match located {
                None => Tried::Solved(panel),
                Some(_) => {
                    let event = located.filter(is_at_end);
                    Tried::UpTo(length_s, Some(panel), event)
                }
            });
        }
        Ok(Tried::TooLong(LENGTH_FACTORS.0 * length_s))
    }

    /// Returns the factor from the length of an interval to the one that its error permits.
    fn factor(&self, error: f64) -> f64 {
        let ratio = self.tolerance / error.max(f64::MIN_POSITIVE);
        (SAFETY * ratio.powf(1.0 / ORDER)).clamp(LENGTH_FACTORS.0, LENGTH_FACTORS.1)
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
        seen: &mut Seen,
    ) -> bool {
        self.intervals += 1;
        let (rule, problem) = (rule(), self.equations.problem);
        // Of a given motion, the displacement is an integral.
        let from_m = self.x_m;
        let velocities: Vec<f64> = panel.points.iter().map(|point| point.v_m_per_s).collect();
        let travelled = |factors: &[f64; STAGES]| factors.iter().zip(&velocities).map(|(factor, v)| factor * v).sum::<f64>();
        let x_m = |node: usize| match problem.motion {
            Motion::Kinematic => from_m + length_s * travelled(&rule.integral[node]),
            Motion::Sdof { .. } => panel.values[node + 1][self.equations.states],
        };
        let displacements: Vec<f64> = std::iter::once(from_m).chain((0..STAGES).map(x_m)).collect();
        for (node, (y, point)) in panel.values[1..].iter().zip(&panel.points).enumerate() {
            add(&mut meter.totals, problem, (displacements[node + 1], point), rule.weight[node] * length_s);
            self.equations.largest_n = self.equations.largest_n.max(point.force_n.abs());
            self.equations.scale.iter_mut().zip(y).for_each(|(scale, y)| *scale = scale.max(y.abs()));
        }
        let gap = self.period_s / SEEN_PER_PERIOD;
        let mut before = 0.0;
        for (node, at) in rule.at.into_iter().enumerate() {
            let parts = if seen.is_some() { ((at - before) * length_s / gap).ceil().max(1.0) as u32 } else { 1 };
            for part in 1..parts {
                let place = before + (at - before) * f64::from(part) / f64::from(parts);
                let factors = rule.factors(place);
                let x_m = factors.iter().zip(&displacements).map(|(factor, x_m)| factor * x_m).sum();
                // Only for the observer: the peaks of the tally do not depend on it.
                if let Some(seen) = seen {
                    seen(&self.state_of(&panel.sum(&factors), x_m, stretch, from_s + place * length_s));
                }
            }
            let point = &panel.points[node];
            let time_s = stretch.start_s + from_s + at * length_s;
            let state = State { time_s, x_m: displacements[node + 1], v_m_per_s: point.v_m_per_s, force_n: point.force_n };
            meter.step(&state, state.force_n / self.equations.coulomb_n);
            if let Some(seen) = seen {
                seen(&state);
            }
            before = at;
        }
        self.x_m = displacements[STAGES];
        if let Some(end) = panel.values.last() {
            self.y.clone_from(end);
        }
        meter.totals.friction_n_s.is_finite()
    }
}

/// Returns `true` if a given motion does not slide; friction then has no direction.
fn stands_still(forcing: &Forcing, size: f64) -> bool {
    size == 0.0 && matches!(forcing, Forcing::Line { slope: 0.0, .. })
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
