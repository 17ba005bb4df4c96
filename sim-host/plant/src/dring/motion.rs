//! Motion of a torso in its belt: steps of integration, and events.
//!
//! Within a [`Mode`] everything is smooth, and a step is one of the classical Runge-Kutta method. A
//! step in which a mode ends is cut at that moment by bisection; the next step begins in the mode
//! that follows. Steps are also cut at the beginning and end of the pulse and of a ramp. While the
//! actuator's law applies, steps are short compared with its settling time.
//!
//! A crash is over when the torso, on its way back, no longer stretches the belt. From then on
//! nothing moves.

use super::Bench;
use super::actuator::Actuator;
use super::mode::{Mode, Phase, Slide, Spool};
use super::span::Part;
use super::state::{Ramp, State, Tensions, Way};
use contact::wrap::table::Table;

/// Longest step, s.
const STEP_S: f64 = 32e-6;
/// Longest step, as a fraction of the settling time of the actuator's law.
const STEP_PER_SETTLING_TIME: f64 = 0.25;
/// Accuracy to which an event is located, s.
const EVENT_TOLERANCE_S: f64 = 1e-12;
/// Shortest step, s: a law that is infinitely steep when it begins to apply soon becomes less
/// steep.
const LEAST_STEP_S: f64 = 1e-16;
/// Events at one moment after which time advances in spite of them.
const MAX_EVENTS_AT_ONCE: u32 = 12;
/// Length of the first forced step, s; it doubles each time that it does not help.
const FORCED_STEP_S: f64 = 1e-9;

/// Extremes of forces, displacements and speeds so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extremes {
    /// Largest force at the shoulder, N.
    pub shoulder_n: f64,
    /// Time of the largest force at the shoulder, s.
    pub shoulder_s: f64,
    /// Largest displacement of the torso, m.
    pub excursion_m: f64,
    /// Fastest payout, m/s, as a mean from one call to the next: when a law begins to apply, the
    /// webbing jumps a little.
    pub payout_m_per_s: f64,
    /// Largest power of the actuator into the contact, W; `None` if its law does not define the
    /// power.
    pub actuator_w: Option<f64>,
}

/// A torso in its belt.
#[derive(Clone, Debug)]
pub struct Motion {
    bench: Bench,
    mode: Mode,
    ramp: Ramp,
    state: State,
    time_s: f64,
    /// `true` if the torso has come back out of the belt.
    over: bool,
    /// Factor by which steps are shorter than usual.
    finer: f64,
    extremes: Extremes,
}

impl Motion {
    /// Creates a motion at rest at time zero, with steps shorter than usual by the factor `finer`.
    pub fn new(bench: Bench, finer: u32) -> Self {
        let part = if bench.shoulder.slack_m > 0.0 { Part::Slack } else { Part::Taut };
        let mode = Mode { slide: Slide::Stuck, spool: Spool::Locked, part, seated: true, pulse: false, ramps: false };
        let (state, extremes) = (State::default(), Extremes::default());
        Motion { bench, mode, ramp: Ramp::default(), state, time_s: 0.0, over: false, finer: finer.into(), extremes }
    }

    fn phase(&self) -> Phase<'_> {
        Phase { bench: &self.bench, mode: self.mode, ramp: self.ramp }
    }

    /// Returns the present positions, speeds and work.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the present mode.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Returns the present tensions, N.
    pub fn tensions(&self) -> Tensions {
        self.phase().tensions(&self.state)
    }

    /// Returns the present speed of the payout, m/s.
    pub fn payout_m_per_s(&self) -> f64 {
        if self.over { 0.0 } else { self.slide_m_per_s() }
    }

    fn slide_m_per_s(&self) -> f64 {
        self.phase().rates(&self.state, self.time_s).payout_m
    }

    /// Returns the extremes of the motion so far.
    pub fn extremes(&self) -> Extremes {
        self.extremes
    }

    /// Returns the amplitude of the actuator, 0 to 1.
    pub fn amplitude(&self) -> f64 {
        self.ramp.amplitude(self.time_s)
    }

    /// Returns the peak velocity and law of a D-ring that vibrates as a whole.
    pub fn ring(&self) -> Option<(f64, &Table)> {
        if let Actuator::Ring(tip_m_per_s, table) = &self.bench.actuator { Some((*tip_m_per_s, table)) } else { None }
    }

    /// Returns the fraction of the pulse's work that is unaccounted for.
    pub fn energy_residual(&self) -> f64 {
        let accounted = self.phase().stored_j(&self.state) + self.state.friction_j + self.state.spool_j;
        // Before the pulse there is nothing to account for.
        if self.state.input_j == 0.0 { 0.0 } else { (self.state.input_j - accounted) / self.state.input_j }
    }

    /// Sets the vibration velocity of a stack's tip, m/s.
    pub fn shake(&mut self, tip_m_per_s: f64) {
        self.bench.actuator = self.bench.actuator.with_tip(tip_m_per_s);
        self.ramp = Ramp { at: 1.0, rate_per_s: 0.0, from_s: self.time_s };
        self.mode = self.phase().reconsidered(&self.state, self.time_s);
    }

    /// Changes the actuator's amplitude at this rate, 1/s, until it is 0 or 1.
    pub fn drive(&mut self, rate_per_s: f64) {
        self.ramp = Ramp { at: self.amplitude(), rate_per_s, from_s: self.time_s };
        self.mode = self.phase().reconsidered(&self.state, self.time_s);
    }

    /// Advances to a moment.
    pub fn advance_to(&mut self, until_s: f64) {
        // Consecutive events that have taken no time.
        let mut in_a_row: u32 = 0;
        let (from_s, payout_m) = (self.time_s, self.state.payout_m);
        while !self.over && self.time_s < until_s - EVENT_TOLERANCE_S {
            let begins_s = self.time_s + 2.0 * EVENT_TOLERANCE_S;
            self.mode.pulse = self.bench.pulse.contains(begins_s);
            self.mode.ramps = begins_s < self.ramp.end_s() && self.ramp.rate_per_s != 0.0;
            let mut step_s = (self.next_cut_s(until_s) - self.time_s).min(STEP_S / self.finer);
            let settles = self.phase().stiffness_per_s(&self.state, self.time_s);
            if settles > 0.0 {
                step_s = step_s.min(STEP_PER_SETTLING_TIME / self.finer / settles).max(LEAST_STEP_S);
            }
            let goes_on = in_a_row > 0 && in_a_row.is_multiple_of(MAX_EVENTS_AT_ONCE);
            if goes_on {
                step_s = step_s.min(FORCED_STEP_S * f64::from(1u32 << (in_a_row / MAX_EVENTS_AT_ONCE).min(20)));
            }
            let (taken_s, next) = self.step(step_s, goes_on);
            let stands = goes_on || next.is_some() && taken_s <= 10.0 * EVENT_TOLERANCE_S;
            in_a_row = if stands { in_a_row + 1 } else { 0 };
            let next = next.unwrap_or(self.mode);
            self.over = self.mode.part == Part::Taut && next.part != Part::Taut && self.state.v_m_per_s < 0.0;
            self.mode = next;
            self.note();
        }
        self.time_s = until_s;
        let speed = (self.state.payout_m - payout_m) / (until_s - from_s);
        self.extremes.payout_m_per_s = self.extremes.payout_m_per_s.max(speed);
    }

    /// Returns the next moment that must not lie inside a step.
    fn next_cut_s(&self, until_s: f64) -> f64 {
        let now_s = self.time_s + 2.0 * EVENT_TOLERANCE_S;
        let cuts = [self.bench.pulse.next_corner_s(now_s), self.ramp.end_s()];
        cuts.into_iter().filter(|cut| *cut > now_s).fold(until_s, f64::min)
    }

    /// Makes a step, or the part of it during which this mode lasts. Returns its length and the
    /// mode that follows, if the mode ends.
    fn step(&mut self, step_s: f64, goes_on: bool) -> (f64, Option<Mode>) {
        let whole = self.tried(step_s);
        let end = self.first_end(&whole, step_s);
        let Some((_, next)) = end.filter(|_| !goes_on) else {
            (self.state, self.time_s) = (whole, self.time_s + step_s);
            return (step_s, None);
        };
        let (mut before_s, mut after_s, mut next) = (0.0, step_s, next);
        while after_s - before_s > EVENT_TOLERANCE_S {
            let middle_s = 0.5 * (before_s + after_s);
            match self.first_end(&self.tried(middle_s), middle_s) {
                Some((_, mode)) => (after_s, next) = (middle_s, mode),
                None => before_s = middle_s,
            }
        }
        (self.state, self.time_s) = (self.tried(after_s), self.time_s + after_s);
        (after_s, Some(next))
    }

    /// Returns the event whose limit the state exceeds most, if it exceeds any.
    fn first_end(&self, state: &State, after_s: f64) -> Option<(f64, Mode)> {
        let ends = self.phase().ends(state, self.time_s + after_s);
        ends.into_iter().filter(|(beyond, _)| *beyond > 0.0).max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Returns the state after a step of the classical Runge-Kutta method.
    fn tried(&self, step_s: f64) -> State {
        let (phase, state, time_s) = (self.phase(), &self.state, self.time_s);
        let half = 0.5 * step_s;
        let one = phase.rates(state, time_s);
        let two = phase.rates(&state.after(&one, half), time_s + half);
        let three = phase.rates(&state.after(&two, half), time_s + half);
        let four = phase.rates(&state.after(&three, step_s), time_s + step_s);
        let sixth = step_s / 6.0;
        state.after(&one, sixth).after(&two, 2.0 * sixth).after(&three, 2.0 * sixth).after(&four, sixth)
    }

    fn note(&mut self) {
        let Tensions { shoulder_n, retractor_n } = self.tensions();
        if shoulder_n > self.extremes.shoulder_n {
            (self.extremes.shoulder_n, self.extremes.shoulder_s) = (shoulder_n, self.time_s);
        }
        self.extremes.excursion_m = self.extremes.excursion_m.max(self.state.x_m);
        if self.amplitude() > 0.0 && self.time_s > self.bench.pulse.at_s {
            let ratio = self.phase().ratio(&self.state, Way::Out).max(self.bench.capstan.floor());
            let power = self.bench.actuator.power_w(self.amplitude(), ratio, (shoulder_n - retractor_n).max(0.0));
            self.extremes.actuator_w = power.map(|power| self.extremes.actuator_w.unwrap_or(0.0).max(power));
        }
    }
}
