//! Runge-Kutta of fourth order between the reversals of the slip.
//!
//! The sign of the slip is a state of its own: it is frozen within a step, so that the right-hand side is analytic there, and it changes
//! only at a reversal, which is located by steps to it (Newton's method inside a bracket). There the slip is set to exactly zero, and
//! no sign is ever taken from its round-off. A step whose slip falls first and rises afterwards is searched for a dip below zero.
//! Order four, where the thesis's method has two. No step straddles two stretches of the timeline.

use super::rates::{FULL, LEAN, Rates, totals};
use super::reversal::{Point, Verdict, between};
use crate::SolveError;
use crate::forcing::Forcing;
use crate::problem::{Law, Motion, Problem};
use crate::tally::{Meter, State, Tally};
use crate::timeline::Timeline;

const METHOD: &str = "rk4-events";

/// More reversals than this in one step are no solution any more.
const MOST_REVERSALS: u32 = 1000;

/// A slip this much smaller than the velocities it is the sum of is zero.
const ROUND_OFF: f64 = 1e-14;

/// Runs a problem with so many steps a period; `watch` sees the state after every step and at every reversal.
pub fn run(problem: &Problem, steps_per_period: u32, watch: &mut impl FnMut(&State)) -> Result<Tally, SolveError> {
    go::<FULL>(problem, steps_per_period, watch)
}

/// Runs a problem without the integrals of the energies, for timing; they are zero in the tally.
pub fn run_plain(problem: &Problem, steps_per_period: u32, watch: &mut impl FnMut(&State)) -> Result<Tally, SolveError> {
    go::<LEAN>(problem, steps_per_period, watch)
}

fn go<const N: usize>(problem: &Problem, steps_per_period: u32, watch: &mut impl FnMut(&State)) -> Result<Tally, SolveError> {
    if problem.law == Law::Coulomb {
        let reason = "Coulomb friction jumps at a reversal and may then stick".into();
        return Err(SolveError::Unsuited { method: METHOD, reason });
    }
    let (rates, y) = Rates::new::<N>(problem);
    let mut walk = Walk { rates, kinematic: problem.motion == Motion::Kinematic, y, sign: 1.0, now: 0.0, k: [0.0; N] };
    let mut meter = Meter::new(N == FULL);
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

/// A run on its way.
struct Walk<const N: usize> {
    rates: Rates,
    kinematic: bool,
    y: [f64; N],
    /// Of the slip, one or minus one.
    sign: f64,
    /// Forcing here.
    now: f64,
    /// Rates here.
    k: [f64; N],
}

impl<const N: usize> Walk<N> {
    fn rates_of(&self, y: &[f64; N], forcing: f64) -> [f64; N] {
        let sign = self.sign;
        self.rates.of(y, forcing, |slip| sign * slip)
    }

    /// The step from here of `h` seconds, at `s` seconds of the stretch.
    #[inline]
    fn along(&self, forcing: &Forcing, s: f64, h: f64) -> ([f64; N], f64) {
        let (sign, at_end) = (self.sign, forcing.value(s + h));
        let y = self.rates.step(&self.y, &self.k, h, (forcing.value(s + 0.5 * h), at_end), |slip| sign * slip);
        (y, at_end)
    }

    /// Slip times sign at a moment of the stretch with the forcing there, and its slope over `h` seconds.
    #[inline]
    fn point(&self, at: f64, (y, k): (&[f64; N], &[f64; N]), forcing: &Forcing, (s, value): (f64, f64), h: f64) -> Point {
        let slope = if self.kinematic { forcing.taylor::<2>(s)[1] } else { k[1] };
        let slip = self.rates.slip(self.rates.velocity(y, value));
        Point { at, value: self.sign * slip, slope: self.sign * self.rates.sign * slope * h }
    }

    /// Round-off of a slip between two moments.
    fn round_off(&self, v0: f64, v1: f64) -> f64 {
        ROUND_OFF * (self.rates.sliding_m_per_s.abs() + v0.abs() + v1.abs())
    }

    /// A stretch begins. At the very start no sign is known, and the velocity of a kinematic motion may have jumped; an oscillator's
    /// has not. Returns whether the sign has changed.
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

    /// Goes from one moment of the stretch to another, reversal by reversal. Returns whether there still is a solution.
    #[inline]
    fn step(&mut self, forcing: &Forcing, from: f64, to: f64, seen: &mut impl FnMut(&Self, f64, bool)) -> bool {
        let mut s = from;
        for _ in 0..MOST_REVERSALS {
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
            // Exactly zero: the sum that makes the slip cancels without a remainder.
            if !self.kinematic {
                self.y[1] = -self.rates.sign * self.rates.sliding_m_per_s;
            }
            self.sign = -self.sign;
            self.k = self.rates_of(&self.y, self.now);
            seen(self, s, true);
        }
        false
    }

    /// Where the slip is after a part of the step.
    fn probe(&self, forcing: &Forcing, s: f64, h: f64, at: f64) -> Point {
        let (y, value) = self.along(forcing, s, at * h);
        let k = self.rates_of(&y, value);
        self.point(at, (&y, &k), forcing, (s + at * h, value), h)
    }

    /// The reversal inside a bracket: Newton from the guess, bisection where it leaves.
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

    /// A minimum below zero, as the bracket of the reversal before it. The minimum is sought where the slope changes its sign.
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
