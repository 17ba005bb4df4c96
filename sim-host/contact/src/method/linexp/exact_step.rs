//! The exact step of [`linexp`](super): a step in substeps, each of which ends at a reversal,
//! before the friction law becomes steep, or at the end of the step.
//!
//! In a part the motion is a polynomial, computed with the first terms of the friction's own
//! series. Kicks at the nodes then contain only the difference of friction from these terms, so the
//! reversal is at the true zero of the slip velocity. The sign of the slip is a separate state: it
//! changes at a reversal and is never taken from the round-off of a velocity near zero.

use super::Options;
use super::decay::decay;
use super::feedback::Feedback;
use super::quadrature::{End, Nodes};
use super::simd_nodes::{Lanes, Places, SimdNodes, combine, place, values};
use super::substep::{Piece, Substep};
use crate::forcing::Forcing;
use crate::method::oscillator::{KERNEL, Oscillator};
use crate::method::polynomial::{first_reversal, slope, value};
use crate::problem::Problem;
use crate::tally::{Meter, State};

/// Largest exponent of friction over one part, times the steps per period.
const MAX_EXPONENT_STEPS: f64 = 64.0;
/// Longest part, in units of the time constant of mass and contact stiffness, sqrt(m / Kt).
pub(super) const LONGEST_PART: f64 = 0.5;
/// Shortest part, as a fraction of a step.
pub(super) const SHORTEST_PART: f64 = 1e-12;
/// Square root of the accuracy to which a reversal is located, as a fraction of a step. Friction
/// has zero slope there, so its error is of the fourth power.
pub(super) const LOCATION_TOLERANCE: f64 = 3e-4;
/// Distance of friction from its bound, over Fc, below which it does not change.
const SATURATION_DISTANCE: f64 = 1e-15;
/// Number of times that friction at the nodes and the motion under it are computed from each other.
pub(super) const PASSES: usize = 2;
/// Exponent whose third power is below round-off.
pub(super) const SMALL_EXPONENT: f64 = 1e-5;

/// State and sums of a run; the motion within a part has `N` coefficients.
pub(super) struct Exact<const K: usize, const N: usize>
where
    Nodes<K>: Places,
{
    pub oscillator: Oscillator,
    /// Displacement, m.
    pub x: f64,
    /// Velocity, m/s.
    pub v: f64,
    /// Friction over Fc.
    pub f: f64,
    /// Friction over Fc with its first two rates, for the present sign of the slip.
    pub here: End,
    /// Sign of the slip velocity.
    pub sense: f64,
    /// Slip velocity, m/s.
    pub slip_velocity: f64,
    /// Rate of the slip velocity, m/s^2.
    pub a: f64,
    /// Sliding speed, m/s.
    pub sliding: f64,
    /// Sign of x' in the slip velocity.
    pub sign: f64,
    pub coulomb_n: f64,
    /// Kt / Fc, 1/m.
    pub per_metre: f64,
    /// Fc / m, m/s^2; zero without dynamics.
    pub push: f64,
    /// Largest exponent of friction over a part.
    pub steepest: f64,
    /// Distance from the bound, over Fc, below which friction does not change.
    pub saturated: f64,
    pub meter: Meter,
    kt: f64,
    pub kernel: [f64; KERNEL],
    /// Displacement at the evaluation points of a piece from a kick at each node, for each power of
    /// the kernel from the first on.
    pub answers: [[Lanes<K>; K]; KERNEL - 1],
    /// `true` if the energies are added up.
    pub with_sums: bool,
    /// `true` if friction acts on the motion.
    coupled: bool,
    /// `true` if the slip has just reversed, and nothing has moved since.
    turned: bool,
}

impl<const K: usize, const N: usize> Exact<K, N>
where
    Nodes<K>: Places,
{
    pub fn new(problem: &Problem, kt: f64, steps_per_period: u32, options: Options) -> Self {
        let with_sums = options == Options::EnergySums;
        let oscillator = Oscillator::new(problem);
        let meter = Meter::new(with_sums);
        let mut run = Exact {
            oscillator,
            x: problem.start.x_m,
            v: problem.start.v_m_per_s,
            f: 0.0,
            here: End { value: 0.0, slope: 0.0, curvature: 0.0 },
            sense: 0.0,
            slip_velocity: 0.0,
            a: 0.0,
            sliding: problem.sliding_m_per_s,
            sign: problem.sign.factor(),
            coulomb_n: problem.coulomb_n,
            per_metre: 0.0,
            push: 0.0,
            steepest: MAX_EXPONENT_STEPS / f64::from(steps_per_period),
            // A part that removes less than round-off of the remaining distance would leave
            // friction where it is.
            saturated: SATURATION_DISTANCE.max(2.0 * f64::EPSILON * f64::from(steps_per_period) / MAX_EXPONENT_STEPS),
            meter,
            kt,
            kernel: oscillator.kernel(),
            answers: std::array::from_fn(|n| Nodes::<K>::answers(|since| since.powi(n as i32 + 1))),
            with_sums,
            coupled: !oscillator.kinematic && options != Options::Frozen,
            turned: false,
        };
        run.set_coulomb_force(problem.coulomb_n);
        run.f = problem.start.force_n / problem.coulomb_n;
        run
    }

    /// Changes the Coulomb force, N; the bristles keep their force.
    pub fn set_coulomb_force(&mut self, coulomb_n: f64) {
        self.f *= self.coulomb_n / coulomb_n;
        self.coulomb_n = coulomb_n;
        self.per_metre = self.kt / coulomb_n;
        self.push = if self.coupled { coulomb_n * self.oscillator.per_mass } else { 0.0 };
    }

    pub fn state(&self, time_s: f64) -> State {
        State { time_s, x_m: self.x, v_m_per_s: self.v, force_n: self.coulomb_n * self.f }
    }

    /// Returns `true` if a step of `h` seconds is too long for the contact at its stiffest.
    pub fn is_stiff(&self, h: f64) -> bool {
        h * h * self.push * self.per_metre * 2.0 > LONGEST_PART * LONGEST_PART
    }

    /// Returns the acceleration under `u`, m/s^2; in a kinematic motion, `u` itself.
    #[inline]
    pub fn acceleration(&self, u: f64, x: f64, v: f64, f: f64) -> f64 {
        u - self.oscillator.damping * v - self.oscillator.stiffness * x - self.push * f
    }

    /// Begins a stretch, whose forcing may have jumped.
    pub fn face(&mut self, forcing: &Forcing, length_s: f64) {
        // A cosine continues the previous one.
        if self.sense != 0.0 && !self.oscillator.kinematic && matches!(forcing, Forcing::Cosine { .. }) {
            self.here = self.end(self.f, self.slip_velocity, self.a);
            return;
        }
        let part = self.part(forcing, 0.0, 1e-3 * length_s);
        if self.oscillator.kinematic {
            self.v = part.v[0];
        }
        self.slip_velocity = self.sliding + self.sign * self.v;
        self.a = self.sign * part.v[1] / part.unit_s;
        // The sign of the slip follows from the preceding motion, except at the start and if a
        // given velocity jumps. A slip that is zero to round-off takes the sign of its first
        // non-zero derivative.
        if self.sense == 0.0 || self.oscillator.kinematic {
            let size = self.sliding.abs() + part.v.iter().map(|c| c.abs()).fold(0.0, f64::max);
            let slip = |(k, c): (usize, &f64)| self.sign * c + if k == 0 { self.sliding } else { 0.0 };
            self.sense = part.v.iter().enumerate().map(slip).find(|c| c.abs() > 1e-12 * size).map_or(1.0, f64::signum);
        }
        self.here = self.end(self.f, self.slip_velocity, self.a);
    }

    /// Computes one step of `h` seconds that begins at `from_s`, of which `done_s` are already
    /// done.
    pub fn step(&mut self, forcing: &Forcing, from_s: f64, h: f64, mut done_s: f64) {
        let mut flips = 0;
        // The last part ends at the end of the step within round-off.
        while h - done_s > 1e-13 * h {
            let left_s = h - done_s;
            let longest = self.longest();
            let unit_s = left_s.min(longest);
            if longest.is_nan() || longest <= SHORTEST_PART * h {
                // The motion has diverged: no part is short enough for it.
                self.x = f64::NAN;
                return;
            }
            let mut part = self.part(forcing, from_s + done_s, unit_s);
            let end = if flips > 1 { self.touch(&mut part) } else { self.go(&mut part) };
            flips = if end * unit_s <= SHORTEST_PART * h { flips + 1 } else { 0 };
            done_s = if end == 1.0 && unit_s == left_s { h } else { done_s + end * unit_s };
        }
    }

    /// Advances along a part, across one reversal at most; returns the fraction of the part that is
    /// done.
    pub fn go(&mut self, part: &mut Substep<N>) -> f64 {
        let mut slip_velocity = part.v;
        slip_velocity.iter_mut().for_each(|c| *c *= self.sign);
        slip_velocity[0] += self.sliding;
        let reversal = first_reversal(&slip_velocity, self.sense, LOCATION_TOLERANCE);
        let end = reversal.unwrap_or(1.0);
        if end > 0.0 {
            let piece = self.piece(part, 0.0, end);
            self.take(part, piece);
        }
        if reversal.is_none() {
            return 1.0;
        }
        self.sense = -self.sense;
        self.here = self.end(self.f, self.slip_velocity, self.a);
        // A reversal found slightly too early, at the end of a step, is undone at the beginning of
        // the next step and found again. It counts once.
        let back = self.turned;
        self.turned = !back;
        let reversals = &mut self.meter.tally.reversals;
        *reversals = if back { reversals.saturating_sub(1) } else { *reversals + 1 };
        // The rest of the part uses the same polynomial, if it has no other event.
        let rest = self.piece(part, end, 1.0);
        if rest.slip_velocity * self.sense > 0.0 && rest.steepness <= self.steepest {
            self.take(part, rest);
            return 1.0;
        }
        end
    }

    /// Advances along a part at whose beginning the slip velocity only touches zero: it has a sign,
    /// but does not reverse.
    pub fn touch(&mut self, part: &mut Substep<N>) -> f64 {
        let slip = self.sliding + self.sign * value(&part.v, 0.5);
        if slip * self.sense < 0.0 {
            self.sense = -self.sense;
            self.here = self.end(self.f, self.slip_velocity, self.a);
        }
        let piece = self.piece(part, 0.0, 1.0);
        self.take(part, piece);
        1.0
    }

    /// Returns the longest permitted part, s: the exponent of friction is bounded, and the contact
    /// stiffness is resolved.
    pub fn longest(&self) -> f64 {
        if (self.f - self.sense).abs() <= self.saturated {
            return f64::INFINITY;
        }
        let slip = self.steepest / self.per_metre;
        let v = self.slip_velocity.abs();
        let by_slip = 2.0 * slip / (v + (v * v + 2.0 * self.a.abs() * slip).sqrt());
        let spring = self.push * self.per_metre * (1.0 - self.sense * self.f).abs();
        by_slip.min(LONGEST_PART / spring.sqrt())
    }

    /// Returns the first terms of friction over Fc, over `unit_s` seconds.
    pub fn friction_terms(&self, unit_s: f64) -> [f64; 3] {
        let End { value, slope, curvature } = self.here;
        [value, unit_s * slope, 0.5 * unit_s * unit_s * curvature]
    }

    /// Computes the motion over `unit_s` seconds, with the first terms of friction.
    pub fn part(&self, forcing: &Forcing, at_s: f64, unit_s: f64) -> Substep<N> {
        let u: [f64; N] = self.oscillator.forcing(forcing, at_s, unit_s);
        let f = self.friction_terms(unit_s);
        let mut driven = u;
        if !self.oscillator.kinematic {
            driven.iter_mut().zip(&f).for_each(|(u, f)| *u -= self.push * f);
        }
        let (x, v) = self.oscillator.series(self.x, self.v, &driven, unit_s);
        Substep::new(unit_s, (x, v), u, f)
    }

    /// Computes the slip from one moment of a part to another; the present state is that at `from`.
    fn piece(&self, part: &mut Substep<N>, from: f64, to: f64) -> Piece<K> {
        let all = Lanes::<K>::all;
        let (length, s, excess) = (to - from, self.sense, self.f - self.sense);
        let end = Lanes::<K>::END;
        let places = Lanes::<K>::each(|lane| if lane < K { from + length * place::<K>(lane) } else { to });
        // The slip from the polynomial, and the friction it gives.
        let slide = (places - all(from)) * all(self.sliding * part.unit_s);
        let there = values(&part.x, places);
        let slips = slide + (there - all(self.x)) * all(self.sign);
        let decays = decay(slips * all(self.per_metre * s));
        let length_s = length * part.unit_s;
        let feedback = Feedback {
            sense: s,
            excess,
            steep: self.per_metre * s,
            sign: self.sign,
            slips,
            predicted: values(&part.f, places),
            weights: Nodes::<K>::weights(length_s * self.push),
            earlier: self.earlier(part, places),
            answers: self.answers(length_s),
        };
        // Kicks set the slip back by so little that the exponential needs only a second-order
        // correction.
        let force = |late: Lanes<K>| all(s) + all(excess) * decays * (all(1.0) + late * (all(1.0) + late * all(0.5)));
        let late_per_m = feedback.steep * self.sign;
        let mut back = feedback.earlier;
        let (mut forces, mut kicks) = (all(s) + all(excess) * decays, all(0.0));
        for pass in 0..PASSES {
            if pass > 0 || part.count > 0 {
                forces = force(back * all(late_per_m));
            }
            kicks = (forces - feedback.predicted) * feedback.weights;
            back = feedback.earlier + combine(kicks, &feedback.answers);
        }
        let late = back * all(late_per_m);
        let mut f = s + excess * decays.lane(end) * (1.0 + late.lane(end) * (1.0 + late.lane(end) * 0.5));
        if late.at_most(SMALL_EXPONENT).at_least(-SMALL_EXPONENT) != late {
            (forces, kicks, back, f) = feedback.exact();
        }
        for lane in 0..K {
            part.kicks[part.count] = (places.lane(lane), kicks.lane(lane));
            part.count += 1;
        }
        let back = back.lane(end);
        let (x, v) = (there.lane(end) - back, value(&part.v, to) - self.answer_velocity(part, to));
        let slip = slips.lane(end) - self.sign * back;
        let steepness = self.per_metre * s * slip;
        let forces = std::array::from_fn(|lane| forces.lane(lane));
        Piece { from, to, forces, x, v, f, slip, slip_velocity: self.sliding + self.sign * v, steepness }
    }

    /// Returns the displacement at the evaluation points of a piece of `length_s` seconds from a
    /// kick at each of its nodes.
    pub fn answers(&self, length_s: f64) -> [Lanes<K>; K] {
        let mut power = 1.0;
        let mut sums = [Lanes::<K>::all(0.0); K];
        for (coefficient, answers) in self.kernel[1..].iter().zip(&self.answers) {
            power *= length_s;
            let scale = Lanes::<K>::all(coefficient * power);
            for (sum, answer) in sums.iter_mut().zip(answers) {
                *sum = *sum + *answer * scale;
            }
        }
        sums
    }

    /// Returns the displacement by which the kicks of the earlier piece of a part have set the
    /// motion back at these places, m.
    pub fn earlier(&self, part: &Substep<N>, places: Lanes<K>) -> Lanes<K> {
        let mut sum = Lanes::<K>::all(0.0);
        for (when, kick) in &part.kicks[..part.count] {
            let since = (places - Lanes::<K>::all(*when)) * Lanes::<K>::all(part.unit_s);
            sum = sum + Lanes::<K>::all(*kick) * values(&self.kernel, since);
        }
        sum
    }

    /// Advances to the end of a piece.
    fn take(&mut self, part: &Substep<N>, piece: Piece<K>) {
        let length_s = (piece.to - piece.from) * part.unit_s;
        let u = if self.oscillator.kinematic { slope(&part.v, piece.to) / part.unit_s } else { value(&part.u, piece.to) };
        let a = self.sign * self.acceleration(u, piece.x, piece.v, piece.f);
        if self.with_sums {
            self.add_energy(part, &piece);
        }
        (self.x, self.v) = (piece.x, piece.v);
        self.add_friction(length_s, &piece.forces, (piece.f, piece.slip_velocity, a), piece.slip);
    }

    /// Returns the displacement by which the kicks so far have set the motion back at a moment of
    /// the part, m.
    pub fn answer(&self, part: &Substep<N>, at: f64) -> f64 {
        let since = |when: f64| (at - when) * part.unit_s;
        part.kicks[..part.count].iter().map(|(when, kick)| kick * value(&self.kernel, since(*when))).sum()
    }

    /// Returns the velocity that the kicks so far have taken away at a moment of the part, m/s.
    pub fn answer_velocity(&self, part: &Substep<N>, at: f64) -> f64 {
        let since = |when: f64| (at - when) * part.unit_s;
        part.kicks[..part.count].iter().map(|(when, kick)| kick * slope(&self.kernel, since(*when))).sum()
    }

    /// Adds up the friction over a step or piece with a slip of `slip`, m, and advances to its end:
    /// friction over Fc, slip velocity and its rate.
    ///
    /// The work needs no quadrature. By Dahl's law the integral of F dz is
    /// `Fc (s z - s (f_end - f) Fc / Kt)`.
    #[inline]
    pub fn add_friction(&mut self, length_s: f64, forces: &[f64; K], (f, slip_velocity, a): (f64, f64, f64), slip: f64) {
        let s = self.sense;
        // Friction at its bound to round-off is set to the bound; otherwise its rates would be that
        // round-off times the stiffness, and its square.
        let f = if (f - s).abs() <= self.saturated { s } else { f };
        let there = self.end(f, slip_velocity, a);
        let ends = [self.here, there];
        let totals = &mut self.meter.totals;
        totals.friction_n_s += self.coulomb_n * length_s * Nodes::<K>::mean(forces, ends, length_s);
        totals.friction_work_j += self.coulomb_n * s * (slip - (f - self.f) / self.per_metre);
        if self.oscillator.kinematic {
            // The whole friction acts on the drive of the motion.
            totals.felt_work_j = totals.friction_work_j;
        }
        (self.f, self.slip_velocity, self.a, self.here) = (f, slip_velocity, a, there);
        self.turned = false;
    }

    /// Returns friction over Fc and its first two rates: `f' = (Kt / Fc) V (1 - s f)`.
    #[inline]
    fn end(&self, f: f64, v: f64, a: f64) -> End {
        let free = self.per_metre * (1.0 - self.sense * f);
        let slope = v * free;
        End { value: f, slope, curvature: a * free - self.per_metre * v * self.sense * slope }
    }
}
