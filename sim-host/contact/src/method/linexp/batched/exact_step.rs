//! The batched exact step of eight contacts, each in its own substeps; see
//! [`exact_step`](super::super::exact_step).
//!
//! A contact that has reached the end of the step waits for the others. Rare cases are handled one
//! by one by the scalar step.

use fearless_simd::{Select, Simd, SimdBase, SimdMask};

use super::super::exact_step::{LOCATION_TOLERANCE, PASSES, SHORTEST_PART, SMALL_EXPONENT};
use super::super::feedback::Feedback;
use super::super::quadrature::Nodes;
use super::super::simd_nodes::{Lanes, Places, SimdNodes, place};
use super::decay::decay;
use super::fast_step::combine;
use super::forcing::Forcings;
use super::reversal::reversals;
use super::state::Batch;
use super::vector::{Mask, Vector, all, numbers, put, slope, value};
use crate::method::oscillator::{INVERSE, KERNEL};

/// Largest number of kicks: those of two pieces, before and after a reversal.
const MAX_KICKS: usize = 6;

/// Motions over one part of each contact; the fields are those of
/// [`Substep`](super::super::substep::Substep).
pub(super) struct Substeps<S: Simd, const N: usize> {
    pub unit_s: Vector<S>,
    pub x: [Vector<S>; N],
    pub v: [Vector<S>; N],
    pub u: [Vector<S>; N],
    pub f: [Vector<S>; 3],
    kicks: [(Vector<S>, Vector<S>); MAX_KICKS],
    count: usize,
}

impl<S: Simd, const N: usize> Substeps<S, N> {
    #[inline(always)]
    pub fn new(unit_s: Vector<S>, (x, v): ([Vector<S>; N], [Vector<S>; N]), u: [Vector<S>; N], f: [Vector<S>; 3]) -> Self {
        let zero = all(unit_s.simd, 0.0);
        Substeps { unit_s, x, v, u, f, kicks: [(zero, zero); MAX_KICKS], count: 0 }
    }

    /// Batched [`Exact::earlier`](super::super::exact_step::Exact::earlier).
    #[inline(always)]
    fn earlier(&self, at: Vector<S>, kernel: &[Vector<S>; KERNEL]) -> Vector<S> {
        let mut sum = all(at.simd, 0.0);
        for (when, kick) in &self.kicks[..self.count] {
            sum += *kick * value(kernel, (at - *when) * self.unit_s);
        }
        sum
    }

    /// Batched [`Exact::answer_velocity`](super::super::exact_step::Exact::answer_velocity), from
    /// the slopes of the kernel.
    #[inline(always)]
    fn answer_velocity(&self, at: Vector<S>, kernel: &[Vector<S>; KERNEL]) -> Vector<S> {
        let mut sum = all(at.simd, -0.0);
        for (when, kick) in &self.kicks[..self.count] {
            sum += *kick * slope(kernel, (at - *when) * self.unit_s);
        }
        sum
    }
}

/// Stretches of parts without a reversal, with the states at their ends.
struct Pieces<S: Simd, const K: usize> {
    forces: [Vector<S>; K],
    x: Vector<S>,
    v: Vector<S>,
    f: Vector<S>,
    slip: Vector<S>,
    slip_velocity: Vector<S>,
    steepness: Vector<S>,
}

impl<S: Simd, const K: usize, const N: usize> Batch<S, K, N>
where
    Nodes<K>: Places,
{
    /// Batched [`Exact::step`](super::super::exact_step::Exact::step) of the contacts in `on`.
    #[inline(always)]
    pub fn step(&mut self, forcings: &Forcings<S>, from_s: Vector<S>, h: Vector<S>, done_s: Vector<S>, on: Mask<S>) {
        let simd = self.simd;
        let (mut done_s, mut flips, mut on) = (done_s, all(simd, 0.0), on);
        loop {
            let left_s = h - done_s;
            on &= left_s.simd_gt(h * 1e-13);
            let longest = self.longest();
            let unit_s = longest.simd_lt(left_s).select(longest, left_s);
            let lost = on & (longest.simd_ne(longest) | longest.simd_le(h * SHORTEST_PART));
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
            flips = far.simd_le(h * SHORTEST_PART).select(flips + 1.0, all(simd, 0.0));
            let whole = end.simd_eq(1.0) & unit_s.simd_eq(left_s);
            done_s = on.select(whole.select(h, done_s + far), done_s);
        }
    }

    /// As [`Exact::part`](super::super::exact_step::Exact::part).
    #[inline(always)]
    fn part(&self, forcings: &Forcings<S>, at_s: Vector<S>, unit_s: Vector<S>) -> Substeps<S, N> {
        let u = forcings.taylor_in(at_s, unit_s, self.per_mass);
        let f = self.friction_terms(unit_s);
        let mut driven = u;
        for (u, f) in driven.iter_mut().zip(&f) {
            *u -= self.push * *f;
        }
        let motion = series((self.damping, self.stiffness), (self.x, self.v), &driven, unit_s);
        Substeps::new(unit_s, motion, u, f)
    }

    /// Batched [`Exact::go`](super::super::exact_step::Exact::go) of the contacts in `on`.
    #[inline(always)]
    pub fn go(&mut self, part: &mut Substeps<S, N>, on: Mask<S>) -> Vector<S> {
        self.simd.vectorize(
            #[inline(always)]
            || self.go_within(part, on),
        )
    }

    #[inline(always)]
    fn go_within(&mut self, part: &mut Substeps<S, N>, on: Mask<S>) -> Vector<S> {
        let simd = self.simd;
        let (zero, one) = (all(simd, 0.0), all(simd, 1.0));
        let mut slip_velocity = part.v;
        for c in &mut slip_velocity {
            *c *= self.sign;
        }
        slip_velocity[0] += self.sliding;
        let (reverses, end) = reversals(&slip_velocity, self.sense, LOCATION_TOLERANCE, on);
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

    /// Batched [`Exact::piece`](super::super::exact_step::Exact::piece) of the contacts in `on`;
    /// the others get no kicks.
    #[inline(always)]
    fn piece(&self, part: &mut Substeps<S, N>, from: Vector<S>, to: Vector<S>, on: Mask<S>) -> Pieces<S, K> {
        self.simd.vectorize(
            #[inline(always)]
            || self.piece_within(part, from, to, on),
        )
    }

    #[inline(always)]
    fn piece_within(&self, part: &mut Substeps<S, N>, from: Vector<S>, to: Vector<S>, on: Mask<S>) -> Pieces<S, K> {
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
        let decays = decay_at::<S, K>(&exponents, on);
        let length_s = length * part.unit_s;
        let (answers, late_per_m, one) = (self.answers(length_s), steep * self.sign, all(simd, 1.0));
        let (mut earlier, mut predicted) = ([zero; 4], [zero; 4]);
        for lane in 0..=K {
            earlier[lane] = part.earlier(places[lane], &self.kernel);
            predicted[lane] = value(&part.f, places[lane]);
        }
        let push = length_s * self.push;
        let (mut back, mut forces, mut kicks) = (earlier, [zero; K], [zero; K]);
        for pass in 0..PASSES {
            for lane in 0..K {
                forces[lane] = s + excess * decays[lane];
                if pass > 0 || part.count > 0 {
                    let late = back[lane] * late_per_m;
                    forces[lane] = s + excess * decays[lane] * (one + late * (one + late * 0.5));
                }
                kicks[lane] = (forces[lane] - predicted[lane]) * (push * Nodes::<K>::WEIGHT[lane]);
            }
            for lane in 0..=K {
                back[lane] = earlier[lane] + combine(&kicks, &answers, lane);
            }
        }
        let late = back[K] * late_per_m;
        let mut f = s + excess * decays[K] * (one + late * (one + late * 0.5));
        let mut large = on & !on;
        for back in &back[..=K] {
            large |= on & !(*back * late_per_m).abs().simd_le(SMALL_EXPONENT);
        }
        for number in numbers(large) {
            let lanes = |of: &[Vector<S>; 4]| Lanes::<K>::each(|lane| of[lane.min(K)][number]);
            let feedback = Feedback {
                sense: s[number],
                excess: excess[number],
                steep: steep[number],
                sign: self.sign[number],
                slips: lanes(&slips),
                predicted: lanes(&predicted),
                weights: Nodes::<K>::weights(push[number]),
                earlier: lanes(&earlier),
                answers: answers.each_ref().map(lanes),
            };
            let exact = feedback.exact();
            for lane in 0..K {
                forces[lane][number] = exact.0.lane(lane);
                kicks[lane][number] = exact.1.lane(lane);
            }
            back[K][number] = exact.2.lane(K);
            f[number] = exact.3;
        }
        for lane in 0..K {
            part.kicks[part.count] = (places[lane], on.select(kicks[lane], zero));
            part.count += 1;
        }
        let back = back[K];
        let (x, v) = (there[K] - back, value(&part.v, to) - part.answer_velocity(to, &self.kernel_slopes));
        let slip = slips[K] - self.sign * back;
        Pieces { forces, x, v, f, slip, slip_velocity: self.sliding + self.sign * v, steepness: steep * slip }
    }

    /// As [`Exact::answers`](super::super::exact_step::Exact::answers).
    #[inline(always)]
    fn answers(&self, length_s: Vector<S>) -> [[Vector<S>; 4]; K] {
        let zero = all(self.simd, 0.0);
        let mut power = all(self.simd, 1.0);
        let mut sums = [[zero; 4]; K];
        for (coefficient, answers) in self.kernel[1..].iter().zip(&self.alone[0].answers) {
            power *= length_s;
            let scale = *coefficient * power;
            for (sums, answers) in sums.iter_mut().zip(answers) {
                for (lane, sum) in sums.iter_mut().enumerate().take(K + 1) {
                    *sum += scale * answers.lane(lane);
                }
            }
        }
        sums
    }

    /// Batched [`Exact::take`](super::super::exact_step::Exact::take) of the chosen contacts.
    #[inline(always)]
    fn take(&mut self, part: &Substeps<S, N>, length: Vector<S>, to: Vector<S>, piece: &Pieces<S, K>, chosen: Mask<S>) {
        let a = self.sign * self.acceleration(value(&part.u, to), piece.x, piece.v, piece.f);
        put(&mut self.x, chosen, piece.x);
        put(&mut self.v, chosen, piece.v);
        self.add_friction(chosen, length * part.unit_s, &piece.forces, (piece.f, piece.slip_velocity, a), piece.slip);
    }
}

/// Returns the decays at the evaluation points of a step with `K` nodes: the nodes and the end.
#[inline(always)]
pub(super) fn decay_at<S: Simd, const K: usize>(exponents: &[Vector<S>; 4], on: Mask<S>) -> [Vector<S>; 4] {
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

/// Batched [`Oscillator::series`](crate::method::oscillator::Oscillator::series) of a non-kinematic
/// oscillator.
#[inline(always)]
pub(super) fn series<S: Simd, const N: usize>(
    (damping, stiffness): (Vector<S>, Vector<S>),
    (x, v): (Vector<S>, Vector<S>),
    u: &[Vector<S>; N],
    unit: Vector<S>,
) -> ([Vector<S>; N], [Vector<S>; N]) {
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
