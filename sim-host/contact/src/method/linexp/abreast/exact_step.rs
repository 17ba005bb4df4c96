//! The exact step of eight contacts, each in substeps of its own: [`exact_step`](super::super::exact_step) abreast.
//!
//! Who has come to the end of the step waits for the others. What nearly never happens is done one by one, by the scalar step itself.

use fearless_simd::{Select, Simd, SimdBase, SimdMask};

use super::super::exact_step::{LOCATED, SHORTEST, SMALL};
use super::super::quadrature::Nodes;
use super::super::simd_nodes::{Places, place};
use super::decay::decay;
use super::forcing::Forcings;
use super::reversal::reversals;
use super::state::Abreast;
use super::vector::{Each, Which, all, numbers, put, slope, value};
use crate::method::oscillator::{INVERSE, KERNEL};

/// Kicks of two pieces, before and after a reversal.
const KICKS: usize = 6;

/// The motions over one part of each, with the names of [`Substep`](super::super::substep::Substep).
pub(super) struct Substeps<S: Simd, const N: usize> {
    pub unit_s: Each<S>,
    pub x: [Each<S>; N],
    pub v: [Each<S>; N],
    pub u: [Each<S>; N],
    pub f: [Each<S>; 3],
    kicks: [(Each<S>, Each<S>); KICKS],
    count: usize,
}

impl<S: Simd, const N: usize> Substeps<S, N> {
    #[inline(always)]
    pub fn new(unit_s: Each<S>, (x, v): ([Each<S>; N], [Each<S>; N]), u: [Each<S>; N], f: [Each<S>; 3]) -> Self {
        let zero = all(unit_s.simd, 0.0);
        Substeps { unit_s, x, v, u, f, kicks: [(zero, zero); KICKS], count: 0 }
    }

    /// As [`Exact::answer`](super::super::exact_step::Exact::answer).
    #[inline(always)]
    fn answer(&self, at: Each<S>, kernel: &[Each<S>; KERNEL]) -> Each<S> {
        let mut sum = all(at.simd, -0.0);
        for (when, kick) in &self.kicks[..self.count] {
            sum += *kick * value(kernel, (at - *when) * self.unit_s);
        }
        sum
    }

    /// As [`Exact::answer_velocity`](super::super::exact_step::Exact::answer_velocity), of the kernel's slopes.
    #[inline(always)]
    fn answer_velocity(&self, at: Each<S>, kernel: &[Each<S>; KERNEL]) -> Each<S> {
        let mut sum = all(at.simd, -0.0);
        for (when, kick) in &self.kicks[..self.count] {
            sum += *kick * slope(kernel, (at - *when) * self.unit_s);
        }
        sum
    }
}

/// What is known of a piece before its kicks: friction less its bound at the beginning, its exponent over the slip, slips and decays.
struct Ahead<S: Simd> {
    excess: Each<S>,
    steep: Each<S>,
    slips: [Each<S>; 4],
    decays: [Each<S>; 4],
}

/// Stretches of parts without a reversal, and the states at their ends.
struct Pieces<S: Simd, const K: usize> {
    forces: [Each<S>; K],
    x: Each<S>,
    v: Each<S>,
    f: Each<S>,
    slip: Each<S>,
    slip_velocity: Each<S>,
    steepness: Each<S>,
}

impl<S: Simd, const K: usize, const N: usize> Abreast<S, K, N>
where
    Nodes<K>: Places,
{
    /// As [`Exact::step`](super::super::exact_step::Exact::step), of those that are `on`.
    #[inline(always)]
    pub fn step(&mut self, forcings: &Forcings<S>, from_s: Each<S>, h: Each<S>, done_s: Each<S>, on: Which<S>) {
        let simd = self.simd;
        let (mut done_s, mut flips, mut on) = (done_s, all(simd, 0.0), on);
        loop {
            let left_s = h - done_s;
            on &= left_s.simd_gt(h * 1e-13);
            let longest = self.longest();
            let unit_s = longest.simd_lt(left_s).select(longest, left_s);
            let lost = on & (longest.simd_ne(longest) | longest.simd_le(h * SHORTEST));
            put(&mut self.x, lost, all(simd, f64::NAN));
            on &= !lost;
            if !on.any_true() {
                return;
            }
            let at_s = from_s + done_s;
            let touch = on & flips.simd_gt(1.0);
            let go = on & !touch;
            let mut end = all(simd, 1.0);
            if go.any_true() {
                let mut part = self.part(forcings, at_s, unit_s);
                end = self.go(&mut part, go);
            }
            for number in numbers(touch) {
                let forcing = forcings.one(number);
                end[number] = self.let_one(number, |run| {
                    let mut part = run.part(&forcing, at_s[number], unit_s[number]);
                    run.touch(&mut part)
                });
            }
            let far = end * unit_s;
            flips = far.simd_le(h * SHORTEST).select(flips + 1.0, all(simd, 0.0));
            let whole = end.simd_eq(1.0) & unit_s.simd_eq(left_s);
            done_s = on.select(whole.select(h, done_s + far), done_s);
        }
    }

    /// As [`Exact::part`](super::super::exact_step::Exact::part).
    #[inline(always)]
    fn part(&self, forcings: &Forcings<S>, at_s: Each<S>, unit_s: Each<S>) -> Substeps<S, N> {
        let u = forcings.taylor_in(at_s, unit_s, self.per_mass);
        let f = self.friction_terms(unit_s);
        let mut driven = u;
        for (u, f) in driven.iter_mut().zip(&f) {
            *u -= self.push * *f;
        }
        let motion = series((self.damping, self.stiffness), (self.x, self.v), &driven, unit_s);
        Substeps::new(unit_s, motion, u, f)
    }

    /// As [`Exact::go`](super::super::exact_step::Exact::go), of those that are `on`.
    #[inline(always)]
    pub fn go(&mut self, part: &mut Substeps<S, N>, on: Which<S>) -> Each<S> {
        self.simd.vectorize(
            #[inline(always)]
            || self.go_within(part, on),
        )
    }

    #[inline(always)]
    fn go_within(&mut self, part: &mut Substeps<S, N>, on: Which<S>) -> Each<S> {
        let simd = self.simd;
        let (zero, one) = (all(simd, 0.0), all(simd, 1.0));
        let mut slip_velocity = part.v;
        for c in &mut slip_velocity {
            *c *= self.sign;
        }
        slip_velocity[0] += self.sliding;
        let (reverses, end) = reversals(&slip_velocity, self.sense, LOCATED, on);
        let first = on & end.simd_gt(0.0);
        if first.any_true() {
            let piece = self.piece(part, zero, end, first);
            self.take(part, end - zero, end, &piece, first);
        }
        if !reverses.any_true() {
            return one;
        }
        self.sense = reverses.select(-self.sense, self.sense);
        self.face(reverses, self.end(self.f, self.slip_velocity, self.a));
        self.reversals = reverses.select(self.reversals + 1.0, self.reversals);
        let rest = self.piece(part, end, one, reverses);
        let goes_on = reverses & (rest.slip_velocity * self.sense).simd_gt(0.0) & rest.steepness.simd_le(self.steepest);
        self.take(part, one - end, one, &rest, goes_on);
        (reverses & !goes_on).select(end, one)
    }

    /// As [`Exact::piece`](super::super::exact_step::Exact::piece), of those that are `on`: the others get no kicks.
    #[inline(always)]
    fn piece(&self, part: &mut Substeps<S, N>, from: Each<S>, to: Each<S>, on: Which<S>) -> Pieces<S, K> {
        self.simd.vectorize(
            #[inline(always)]
            || self.piece_within(part, from, to, on),
        )
    }

    #[inline(always)]
    fn piece_within(&self, part: &mut Substeps<S, N>, from: Each<S>, to: Each<S>, on: Which<S>) -> Pieces<S, K> {
        let simd = self.simd;
        let zero = all(simd, 0.0);
        let (length, s) = (to - from, self.sense);
        let excess = self.f - s;
        let sliding = self.sliding * part.unit_s;
        let steep = self.per_metre * s;
        let (mut places, mut there, mut slips, mut exponents) = ([to; 4], [zero; 4], [zero; 4], [zero; 4]);
        for lane in 0..=K {
            if lane < K {
                places[lane] = from + length * place::<K>(lane);
            }
            there[lane] = value(&part.x, places[lane]);
            slips[lane] = (places[lane] - from) * sliding + (there[lane] - self.x) * self.sign;
            exponents[lane] = slips[lane] * steep;
        }
        let ahead = Ahead { excess, steep, slips, decays: decay_at::<S, K>(&exponents, on) };
        let mut forces = [zero; K];
        for lane in 0..K {
            let at = places[lane];
            forces[lane] = self.force(&ahead, lane, part.answer(at, &self.kernel), on);
            let weight = length * Nodes::<K>::WEIGHT[lane] * part.unit_s;
            let kick = weight * self.push * (forces[lane] - value(&part.f, at));
            part.kicks[part.count] = (at, on.select(kick, zero));
            part.count += 1;
        }
        let back = part.answer(to, &self.kernel);
        let (x, v) = (there[K] - back, value(&part.v, to) - part.answer_velocity(to, &self.kernel_slopes));
        let slip = ahead.slips[K] - self.sign * back;
        Pieces {
            forces,
            x,
            v,
            f: self.force(&ahead, K, back, on),
            slip,
            slip_velocity: self.sliding + self.sign * v,
            steepness: steep * slip,
        }
    }

    /// Friction at a place, where the kicks so far have set the slip back.
    #[inline(always)]
    fn force(&self, ahead: &Ahead<S>, lane: usize, back: Each<S>, on: Which<S>) -> Each<S> {
        let Ahead { excess, steep, slips, decays } = ahead;
        let (s, one) = (self.sense, all(self.simd, 1.0));
        let late = *steep * self.sign * back;
        let mut force = s + *excess * decays[lane] * (one + late * (one + late * 0.5));
        for number in numbers(on & !late.abs().simd_lt(SMALL)) {
            let exponent = late[number] - steep[number] * slips[lane][number];
            force[number] = s[number] + excess[number] * exponent.min(0.0).exp();
        }
        force
    }

    /// As [`Exact::take`](super::super::exact_step::Exact::take), of those that are chosen.
    #[inline(always)]
    fn take(&mut self, part: &Substeps<S, N>, length: Each<S>, to: Each<S>, piece: &Pieces<S, K>, chosen: Which<S>) {
        let a = self.sign * self.acceleration(value(&part.u, to), piece.x, piece.v, piece.f);
        put(&mut self.x, chosen, piece.x);
        put(&mut self.v, chosen, piece.v);
        self.add_friction(chosen, length * part.unit_s, &piece.forces, (piece.f, piece.slip_velocity, a), piece.slip);
    }
}

/// The decays at as many places as a step with `K` nodes has: those and its end.
#[inline(always)]
pub(super) fn decay_at<S: Simd, const K: usize>(exponents: &[Each<S>; 4], on: Which<S>) -> [Each<S>; 4] {
    let [a, b, c, d] = *exponents;
    match K {
        1 => {
            let [a, b] = decay(&[a, b], on);
            [a, b, c, d]
        }
        2 => {
            let [a, b, c] = decay(&[a, b, c], on);
            [a, b, c, d]
        }
        _ => decay(&[a, b, c, d], on),
    }
}

/// As [`Oscillator::series`](crate::method::oscillator::Oscillator::series) of an oscillator.
#[inline(always)]
pub(super) fn series<S: Simd, const N: usize>(
    (damping, stiffness): (Each<S>, Each<S>),
    (x, v): (Each<S>, Each<S>),
    u: &[Each<S>; N],
    unit: Each<S>,
) -> ([Each<S>; N], [Each<S>; N]) {
    let zero = all(unit.simd, 0.0);
    let (mut xs, mut vs) = ([zero; N], [zero; N]);
    (xs[0], vs[0]) = (x, v);
    for k in 1..N {
        let scale = unit * INVERSE[k];
        vs[k] = scale * (u[k - 1] - damping * vs[k - 1] - stiffness * xs[k - 1]);
        xs[k] = scale * vs[k - 1];
    }
    (xs, vs)
}
