//! State and sums of eight batched runs, with one vector per quantity; see [`Exact`].

use fearless_simd::{Select, Simd, SimdBase, SimdFloat};

use super::super::exact_step::{Exact, LONGEST_PART};
use super::super::quadrature::{End, Nodes};
use super::super::simd_nodes::Places;
use super::vector::{Mask, Vector, WIDTH, all, each, put, times_k};
use crate::method::oscillator::KERNEL;

/// Friction over Fc with its first two rates.
#[derive(Clone, Copy)]
pub(super) struct Rates<S: Simd> {
    pub value: Vector<S>,
    pub slope: Vector<S>,
    pub curvature: Vector<S>,
}

/// Eight batched runs; the fields are those of [`Exact`].
pub(super) struct Batch<S: Simd, const K: usize, const N: usize>
where
    Nodes<K>: Places,
{
    pub simd: S,
    pub x: Vector<S>,
    pub v: Vector<S>,
    pub f: Vector<S>,
    pub here: Rates<S>,
    pub sense: Vector<S>,
    pub slip_velocity: Vector<S>,
    pub a: Vector<S>,
    pub friction_n_s: Vector<S>,
    pub friction_work_j: Vector<S>,
    pub reversals: Vector<S>,
    pub sliding: Vector<S>,
    pub sign: Vector<S>,
    pub coulomb_n: Vector<S>,
    pub per_metre: Vector<S>,
    pub push: Vector<S>,
    pub damping: Vector<S>,
    pub stiffness: Vector<S>,
    pub per_mass: Vector<S>,
    pub steepest: f64,
    pub saturated: f64,
    pub kernel: [Vector<S>; KERNEL],
    /// Coefficients of the kernel times their index.
    pub kernel_slopes: [Vector<S>; KERNEL],
    /// The same runs as scalars: their constants and meters, and their state while one runs alone.
    pub alone: [Exact<K, N>; WIDTH],
}

impl<S: Simd, const K: usize, const N: usize> Batch<S, K, N>
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
        Batch {
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

    /// Applies a scalar operation to one of the runs.
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

    /// Batched [`Exact::acceleration`].
    #[inline(always)]
    pub fn acceleration(&self, u: Vector<S>, x: Vector<S>, v: Vector<S>, f: Vector<S>) -> Vector<S> {
        u - self.damping * v - self.stiffness * x - self.push * f
    }

    /// Batched [`Exact::longest`].
    #[inline(always)]
    pub fn longest(&self) -> Vector<S> {
        let simd = self.simd;
        let still = (self.f - self.sense).abs().simd_le(self.saturated);
        let slip = all(simd, self.steepest) / self.per_metre;
        let v = self.slip_velocity.abs();
        let by_slip = slip * 2.0 / (v + (v * v + self.a.abs() * 2.0 * slip).sqrt());
        let spring = self.push * self.per_metre * (all(simd, 1.0) - self.sense * self.f).abs();
        let by_spring = all(simd, LONGEST_PART) / spring.sqrt();
        still.select(all(simd, f64::INFINITY), least(by_slip, by_spring))
    }

    /// Batched [`Exact::friction_terms`].
    #[inline(always)]
    pub fn friction_terms(&self, unit_s: Vector<S>) -> [Vector<S>; 3] {
        let Rates { value, slope, curvature } = self.here;
        [value, unit_s * slope, unit_s * 0.5 * unit_s * curvature]
    }

    /// Batched [`Exact::end`].
    #[inline(always)]
    pub fn end(&self, f: Vector<S>, v: Vector<S>, a: Vector<S>) -> Rates<S> {
        let free = self.per_metre * (all(self.simd, 1.0) - self.sense * f);
        let slope = v * free;
        Rates { value: f, slope, curvature: a * free - self.per_metre * v * self.sense * slope }
    }

    /// Sets the friction rates of the chosen runs.
    #[inline(always)]
    pub fn face(&mut self, chosen: Mask<S>, rates: Rates<S>) {
        put(&mut self.here.value, chosen, rates.value);
        put(&mut self.here.slope, chosen, rates.slope);
        put(&mut self.here.curvature, chosen, rates.curvature);
    }

    /// Batched [`Exact::add_friction`] of the chosen runs.
    #[inline(always)]
    pub fn add_friction(
        &mut self,
        chosen: Mask<S>,
        length_s: Vector<S>,
        forces: &[Vector<S>; K],
        (f, slip_velocity, a): (Vector<S>, Vector<S>, Vector<S>),
        slip: Vector<S>,
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

    /// Batched [`Nodes::mean`] from the present state to `there`.
    #[inline(always)]
    fn mean(&self, nodes: &[Vector<S>; K], there: &Rates<S>, h: Vector<S>) -> Vector<S> {
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

/// Returns the smaller of two numbers; the first if the second is NaN.
#[inline(always)]
pub(super) fn least<S: Simd>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    (b.simd_lt(a) | a.simd_ne(a)).select(b, a)
}
