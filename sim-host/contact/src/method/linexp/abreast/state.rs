//! State and sums of eight runs: [`Exact`] abreast, number by number.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat};

use super::super::exact_step::{Exact, LONGEST};
use super::super::quadrature::{End, Nodes};
use super::super::simd_nodes::Places;
use super::vector::{Each, WIDTH, Which, all, each, put, times_k};
use crate::method::oscillator::KERNEL;

/// Friction over Fc and its first two rates.
#[derive(Clone, Copy)]
pub(super) struct Rates<S: Simd> {
    pub value: Each<S>,
    pub slope: Each<S>,
    pub curvature: Each<S>,
}

/// Eight runs, with the names of [`Exact`].
pub(super) struct Abreast<S: Simd, const K: usize, const N: usize>
where
    Nodes<K>: Places,
{
    pub simd: S,
    pub x: Each<S>,
    pub v: Each<S>,
    pub f: Each<S>,
    pub here: Rates<S>,
    pub sense: Each<S>,
    pub slip_velocity: Each<S>,
    pub a: Each<S>,
    pub friction_n_s: Each<S>,
    pub friction_work_j: Each<S>,
    pub reversals: Each<S>,
    pub sliding: Each<S>,
    pub sign: Each<S>,
    pub coulomb_n: Each<S>,
    pub per_metre: Each<S>,
    pub push: Each<S>,
    pub damping: Each<S>,
    pub stiffness: Each<S>,
    pub per_mass: Each<S>,
    pub steepest: f64,
    pub saturated: f64,
    pub kernel: [Each<S>; KERNEL],
    /// Its coefficients times their index.
    pub kernel_slopes: [Each<S>; KERNEL],
    /// The same runs one by one: their constants and meters, and their state where one goes alone.
    pub alone: [Exact<K, N>; WIDTH],
}

impl<S: Simd, const K: usize, const N: usize> Abreast<S, K, N>
where
    Nodes<K>: Places,
{
    #[inline(always)]
    pub fn new(simd: S, alone: [Exact<K, N>; WIDTH]) -> Self {
        let of = |read: fn(&Exact<K, N>) -> f64| each(simd, |number| read(&alone[number]));
        let kernel = std::array::from_fn(|k| each(simd, |number| alone[number].kernel[k]));
        let rates =
            Rates { value: of(|run| run.here.value), slope: of(|run| run.here.slope), curvature: of(|run| run.here.curvature) };
        let zero = all(simd, 0.0);
        Abreast {
            simd,
            x: of(|run| run.x),
            v: of(|run| run.v),
            f: of(|run| run.f),
            here: rates,
            sense: of(|run| run.sense),
            slip_velocity: of(|run| run.slip_velocity),
            a: of(|run| run.a),
            friction_n_s: zero,
            friction_work_j: zero,
            reversals: zero,
            sliding: of(|run| run.sliding),
            sign: of(|run| run.sign),
            coulomb_n: of(|run| run.coulomb_n),
            per_metre: of(|run| run.per_metre),
            push: of(|run| run.push),
            damping: of(|run| run.oscillator.damping),
            stiffness: of(|run| run.oscillator.stiffness),
            per_mass: of(|run| run.oscillator.per_mass),
            steepest: alone[0].steepest,
            saturated: alone[0].saturated,
            kernel,
            kernel_slopes: times_k(&kernel),
            alone,
        }
    }

    /// Lets one of the runs do something alone.
    #[inline(always)]
    pub fn let_one<T>(&mut self, number: usize, act: impl FnOnce(&mut Exact<K, N>) -> T) -> T {
        let run = &mut self.alone[number];
        (run.x, run.v, run.f) = (self.x[number], self.v[number], self.f[number]);
        let Rates { value, slope, curvature } = &self.here;
        run.here = End { value: value[number], slope: slope[number], curvature: curvature[number] };
        (run.sense, run.slip_velocity, run.a) = (self.sense[number], self.slip_velocity[number], self.a[number]);
        run.meter.totals.friction_n_s = self.friction_n_s[number];
        run.meter.totals.friction_work_j = self.friction_work_j[number];
        let before = run.meter.tally.reversals;
        let done = act(run);
        self.reversals[number] += (run.meter.tally.reversals - before) as f64;
        run.meter.tally.reversals = before;
        (self.x[number], self.v[number], self.f[number]) = (run.x, run.v, run.f);
        self.here.value[number] = run.here.value;
        self.here.slope[number] = run.here.slope;
        self.here.curvature[number] = run.here.curvature;
        (self.sense[number], self.slip_velocity[number], self.a[number]) = (run.sense, run.slip_velocity, run.a);
        self.friction_n_s[number] = run.meter.totals.friction_n_s;
        self.friction_work_j[number] = run.meter.totals.friction_work_j;
        done
    }

    /// As [`Exact::acceleration`].
    #[inline(always)]
    pub fn acceleration(&self, u: Each<S>, x: Each<S>, v: Each<S>, f: Each<S>) -> Each<S> {
        u - self.damping * v - self.stiffness * x - self.push * f
    }

    /// As [`Exact::longest`].
    #[inline(always)]
    pub fn longest(&self) -> Each<S> {
        let simd = self.simd;
        let still = (self.f - self.sense).abs().simd_le(self.saturated);
        let slip = all(simd, self.steepest) / self.per_metre;
        let v = self.slip_velocity.abs();
        let by_slip = slip * 2.0 / (v + (v * v + self.a.abs() * 2.0 * slip).sqrt());
        let spring = self.push * self.per_metre * (all(simd, 1.0) - self.sense * self.f).abs();
        let by_spring = all(simd, LONGEST) / spring.sqrt();
        still.select(all(simd, f64::INFINITY), least(by_slip, by_spring))
    }

    /// As [`Exact::friction_terms`].
    #[inline(always)]
    pub fn friction_terms(&self, unit_s: Each<S>) -> [Each<S>; 3] {
        let Rates { value, slope, curvature } = self.here;
        [value, unit_s * slope, unit_s * 0.5 * unit_s * curvature]
    }

    /// As [`Exact::end`].
    #[inline(always)]
    pub fn end(&self, f: Each<S>, v: Each<S>, a: Each<S>) -> Rates<S> {
        let free = self.per_metre * (all(self.simd, 1.0) - self.sense * f);
        let slope = v * free;
        Rates { value: f, slope, curvature: a * free - self.per_metre * v * self.sense * slope }
    }

    /// Takes the rates of those that are chosen.
    #[inline(always)]
    pub fn face(&mut self, chosen: Which<S>, rates: Rates<S>) {
        put(&mut self.here.value, chosen, rates.value);
        put(&mut self.here.slope, chosen, rates.slope);
        put(&mut self.here.curvature, chosen, rates.curvature);
    }

    /// As [`Exact::add_friction`], of those that are chosen.
    #[inline(always)]
    pub fn add_friction(
        &mut self,
        chosen: Which<S>,
        length_s: Each<S>,
        forces: &[Each<S>; K],
        (f, slip_velocity, a): (Each<S>, Each<S>, Each<S>),
        slip: Each<S>,
    ) {
        let s = self.sense;
        let f = (f - s).abs().simd_le(self.saturated).select(s, f);
        let there = self.end(f, slip_velocity, a);
        let added = self.coulomb_n * length_s * self.mean(forces, &there, length_s);
        self.friction_n_s = chosen.select(self.friction_n_s + added, self.friction_n_s);
        let work = self.coulomb_n * s * (slip - (f - self.f) / self.per_metre);
        self.friction_work_j = chosen.select(self.friction_work_j + work, self.friction_work_j);
        put(&mut self.f, chosen, f);
        put(&mut self.slip_velocity, chosen, slip_velocity);
        put(&mut self.a, chosen, a);
        self.face(chosen, there);
    }

    /// As [`Nodes::mean`], from here to there.
    #[inline(always)]
    fn mean(&self, nodes: &[Each<S>; K], there: &Rates<S>, h: Each<S>) -> Each<S> {
        let here = &self.here;
        let mut inner = all(self.simd, -0.0);
        for (value, weight) in nodes.iter().zip(Nodes::<K>::MEAN) {
            inner += *value * weight;
        }
        let (value, slope, curvature) = Nodes::<K>::OUTER;
        let outer = (here.value + there.value) * value + h * slope * (here.slope - there.slope);
        inner + outer + h * curvature * h * (here.curvature + there.curvature)
    }
}

/// The smaller of two; the first where the second is no number.
#[inline(always)]
pub(super) fn least<S: Simd>(a: Each<S>, b: Each<S>) -> Each<S> {
    (b.simd_lt(a) | a.simd_ne(a)).select(b, a)
}
