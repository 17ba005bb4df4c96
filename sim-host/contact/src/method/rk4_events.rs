//! Fourth-order Runge-Kutta between the reversals of the slip.
//!
//! The sign of the slip is a separate state. It is constant within a step, so that the right-hand
//! side is analytic there, and changes only at a reversal. A reversal is located by steps towards
//! it (Newton's method inside a bracket). There the slip is set to exactly zero, and no sign is
//! ever taken from its round-off. If the slip first falls and then rises within a step, the step is
//! searched for a dip below zero.
//!
//! The method is of fourth order; the thesis's method is of second order. No step crosses the
//! boundary between two stretches of the timeline.

use super::rates::{FULL_STATES, LEAN_STATES, Rates, totals};
use super::reversal::{Point, Verdict, between};
use crate::SolveError;
use crate::forcing::Forcing;
use crate::problem::{Law, Motion, Problem};
use crate::tally::{Meter, State, Tally};
use crate::timeline::Timeline;

const METHOD: &str = "rk4-events";

/// Number of reversals within one step above which the solution counts as diverged.
const MAX_REVERSALS_PER_STEP: u32 = 1000;

/// Round-off of the slip, relative to the velocities of which it is the sum.
const ROUND_OFF_REL: f64 = 1e-14;

/// Runs a problem with a number of steps per period; `watch` receives the state after every step
/// and at every reversal.
pub fn run(problem: &Problem, steps_per_period: u32, watch: &mut dyn FnMut(&State)) -> Result<Tally, SolveError> {
    go::<FULL_STATES>(problem, steps_per_period, watch)
}

/// Runs a problem without the integrals of the energies, for timing; they are zero in the tally.
pub fn run_plain(problem: &Problem, steps_per_period: u32, watch: &mut dyn FnMut(&State)) -> Result<Tally, SolveError> {
    go::<LEAN_STATES>(problem, steps_per_period, watch)
}

fn go<const N: usize>(problem: &Problem, steps_per_period: u32, watch: &mut dyn FnMut(&State)) -> Result<Tally, SolveError> {
    if problem.law == Law::Coulomb {
        let reason = "Coulomb friction jumps at a reversal and may then stick".into();
        return Err(SolveError::Unsuited { method: METHOD, reason });
    }
    let (rates, y) = Rates::new::<N>(problem);
    let mut walk = Walk { rates, kinematic: problem.motion == Motion::Kinematic, y, sign: 1.0, now: 0.0, k: [0.0; N] };
    let mut meter = Meter::new(N == FULL_STATES);
    let mut state = problem.start;
    for stretch in Timeline::new(problem) {
        if let Some(force) = stretch.load {
            walk.rates.load(&mut walk.y, force);
        }
        let steps = stretch.steps(steps_per_period);
        let h = stretch.length_s / f64::from(steps);
        let starts = stretch.start_s == 0.0;
        let turned = walk.enter(&stretch.forcing, h, starts);
        meter.tally.reversals += u64::from(turned && !starts);
        meter.totals = totals(&walk.y);
        state = walk.rates.state(&walk.y, walk.now, stretch.start_s);
        meter.at(&stretch, &state, walk.rates.coulomb_n);
        for step in 0..steps {
            let (from, to) = (f64::from(step) * h, f64::from(step + 1) * h);
            let seen = &mut |walk: &Walk<N>, s: f64, reversed: bool| {
                state = walk.rates.state(&walk.y, walk.now, stretch.start_s + s);
                meter.tally.reversals += u64::from(reversed);
                meter.step(&state, state.force_n / walk.rates.coulomb_n);
                watch(&state);
            };
            if !walk.step(&stretch.forcing, from, to, seen) {
                return Err(SolveError::Diverged { method: METHOD, time_s: stretch.start_s + from });
            }
        }
    }
    meter.totals = totals(&walk.y);
    Ok(meter.finish(&state, walk.rates.coulomb_n))
}

/// State of a run.
struct Walk<const N: usize> {
    rates: Rates,
    kinematic: bool,
    y: [f64; N],
    /// Sign of the slip, one or minus one.
    sign: f64,
    /// Present forcing.
    now: f64,
    /// Present rates.
    k: [f64; N],
}

impl<const N: usize> Walk<N> {
    fn rates_of(&self, y: &[f64; N], forcing: f64) -> [f64; N] {
        let sign = self.sign;
        self.rates.derivatives(y, forcing, |slip| sign * slip)
    }

    /// Computes a step of `h` seconds from the present state, `s` seconds after the beginning of
    /// the stretch.
    #[inline]
    fn along(&self, forcing: &Forcing, s: f64, h: f64) -> ([f64; N], f64) {
        let (sign, at_end) = (self.sign, forcing.value(s + h));
        let y = self.rates.step(&self.y, &self.k, h, (forcing.value(s + 0.5 * h), at_end), |slip| sign * slip);
        (y, at_end)
    }

    /// Returns slip times sign at a moment of the stretch with the forcing there, and its slope
    /// over `h` seconds.
    #[inline]
    fn point(&self, at: f64, (y, k): (&[f64; N], &[f64; N]), forcing: &Forcing, (s, value): (f64, f64), h: f64) -> Point {
        let slope = if self.kinematic { forcing.taylor::<2>(s)[1] } else { k[1] };
        let slip = self.rates.slip(self.rates.velocity(y, value));
        Point { at, value: self.sign * slip, slope: self.sign * self.rates.sign * slope * h }
    }

    /// Returns the round-off of a slip between two moments.
    fn round_off(&self, v0: f64, v1: f64) -> f64 {
        ROUND_OFF_REL * (self.rates.sliding_m_per_s.abs() + v0.abs() + v1.abs())
    }

    /// Begins a stretch and returns `true` if the sign has changed.
    ///
    /// The sign is `unknown` at the very start. The velocity of a kinematic motion may jump between
    /// stretches; that of an oscillator does not.
    fn enter(&mut self, forcing: &Forcing, h: f64, unknown: bool) -> bool {
        let before = self.sign;
        self.now = forcing.value(0.0);
        self.k = self.rates_of(&self.y, self.now);
        if unknown || self.kinematic {
            let here = self.point(0.0, (&self.y, &self.k), forcing, (0.0, self.now), h);
            let v = self.rates.velocity(&self.y, self.now);
            if here.value.abs() > self.round_off(v, v) {
                self.sign *= here.value.signum();
            } else if here.slope != 0.0 {
                self.sign *= here.slope.signum();
            }
            self.k = self.rates_of(&self.y, self.now);
        }
        self.sign != before
    }

    /// Advances from one moment of the stretch to another, reversal by reversal. Returns `false` if
    /// the solution has diverged.
    #[inline]
    fn step(&mut self, forcing: &Forcing, from: f64, to: f64, seen: &mut impl FnMut(&Self, f64, bool)) -> bool {
        let mut s = from;
        for _ in 0..MAX_REVERSALS_PER_STEP {
            let h = to - s;
            let (y, at_end) = self.along(forcing, s, h);
            if self.rates.escaped(&y) {
                return false;
            }
            let k = self.rates_of(&y, at_end);
            let first = self.point(0.0, (&self.y, &self.k), forcing, (s, self.now), h);
            let last = self.point(1.0, (&y, &k), forcing, (to, at_end), h);
            let round_off = self.round_off(self.rates.velocity(&self.y, self.now), self.rates.velocity(&y, at_end));
            let at = match between(&first, &last, round_off) {
                Verdict::Keeps => None,
                Verdict::AtOnce => Some(0.0),
                Verdict::Reverses { low, high, guess } => Some(self.locate(forcing, s, h, (low, high, guess), round_off)),
                Verdict::Dips(guess) => self
                    .dip(forcing, s, h, (first, last, guess), round_off)
                    .map(|bracket| self.locate(forcing, s, h, bracket, round_off)),
            };
            let Some(at) = at.filter(|at| (1.0 - at) * h > 1e-12 * (to - from)) else {
                (self.y, self.k, self.now) = (y, k, at_end);
                seen(self, to, false);
                return true;
            };
            if at > 0.0 {
                self.y = self.along(forcing, s, at * h).0;
            }
            s += at * h;
            self.now = forcing.value(s);
            // Makes the slip exactly zero: its sum cancels without a remainder.
            if !self.kinematic {
                self.y[1] = -self.rates.sign * self.rates.sliding_m_per_s;
            }
            self.sign = -self.sign;
            self.k = self.rates_of(&self.y, self.now);
            seen(self, s, true);
        }
        false
    }

    /// Returns slip and slope after a fraction of the step.
    fn probe(&self, forcing: &Forcing, s: f64, h: f64, at: f64) -> Point {
        let (y, value) = self.along(forcing, s, at * h);
        let k = self.rates_of(&y, value);
        self.point(at, (&y, &k), forcing, (s + at * h, value), h)
    }

    /// Locates the reversal inside a bracket: Newton's method from the guess, bisection if it
    /// leaves the bracket.
    fn locate(&self, forcing: &Forcing, s: f64, h: f64, bracket: (f64, f64, f64), round_off: f64) -> f64 {
        let (mut low, mut high, mut at) = bracket;
        for _ in 0..60 {
            let here = self.probe(forcing, s, h, at);
            if here.value.abs() <= round_off || high - low < 1e-15 {
                break;
            }
            if here.value > 0.0 {
                low = at
            } else {
                high = at
            }
            let newton = at - here.value / here.slope;
            at = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        at
    }

    /// Searches for a minimum below zero, at the change of sign of the slope. Returns the bracket
    /// of the reversal before it.
    fn dip(&self, forcing: &Forcing, s: f64, h: f64, span: (Point, Point, f64), round_off: f64) -> Option<(f64, f64, f64)> {
        let (first, mut last, mut guess) = span;
        let mut left = first;
        for _ in 0..8 {
            let here = self.probe(forcing, s, h, guess);
            if here.value < -round_off {
                let Verdict::Reverses { low, high, guess } = between(&first, &here, round_off) else { return None };
                return Some((low, high, guess));
            }
            if here.slope < 0.0 {
                left = here
            } else {
                last = here
            }
            match between(&left, &last, round_off) {
                Verdict::Dips(next) if (next - guess).abs() > 1e-9 => guess = next,
                _ => return None,
            }
        }
        None
    }
}
