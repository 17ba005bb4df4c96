//! Batched tables of the flows of eight contacts over each step of a period; see
//! [`Table`](super::super::fast_step::Table).

use fearless_simd::Simd;

use super::super::fast_step::TABLE_TERMS;
use super::super::quadrature::Nodes;
use super::super::simd_nodes::{Places, SimdNodes, place};
use super::exact_step::{Substeps, series};
use super::forcing::Forcings;
use super::state::Batch;
use super::vector::{Vector, WIDTH, all, each, value};
use crate::method::polynomial;

/// Tables of eight contacts; the fields are those of [`Table`](super::super::fast_step::Table). The
/// evaluation points are the nodes, then the end.
pub(super) struct Tables<S: Simd, const K: usize, const N: usize> {
    pub h: Vector<S>,
    pub x: By<S>,
    pub v_end: [Vector<S>; 4],
    pub slide: [Vector<S>; 4],
    pub kick: [[Vector<S>; 4]; K],
    pub weights: [Vector<S>; K],
    pub kick_end: [Vector<S>; K],
    pub at_s: [Vector<S>; K],
    by: [Series<S, N>; 5],
    pub forced: Vec<Forced<S>>,
    /// Contribution of the forcing as polynomials, and the forcing itself; stored separately
    /// because few steps need them.
    curves: Vec<(Series<S, N>, [Vector<S>; N])>,
}

/// Coefficients of displacement and velocity over a step.
type Series<S, const N: usize> = ([Vector<S>; N], [Vector<S>; N]);

/// Displacements at the evaluation points, for each quantity that contributes to them.
pub(super) struct By<S: Simd> {
    pub x: [Vector<S>; 4],
    pub v: [Vector<S>; 4],
    pub push: [Vector<S>; 4],
    pub push_rate: [Vector<S>; 4],
}

/// Contribution of the forcing within one step.
pub(super) struct Forced<S: Simd> {
    pub x: [Vector<S>; 4],
    pub v_end: Vector<S>,
    pub last: Vector<S>,
}

impl<S: Simd, const K: usize, const N: usize> Tables<S, K, N>
where
    Nodes<K>: Places,
{
    #[inline(always)]
    pub fn new(runs: &Batch<S, K, N>, forcings: &Forcings<S>, steps: u32, h: Vector<S>) -> Self {
        let simd = runs.simd;
        let (zero, unit) = (all(simd, 0.0), all(simd, 1.0));
        let none = [zero; TABLE_TERMS];
        let (mut push, mut linear, mut square, mut rate) = (none, none, none, none);
        (push[0], linear[1], square[2], rate[1]) = (unit, unit, unit, h);
        let by_x = flow(runs, (unit, zero), &none, h);
        let by_v = flow(runs, (zero, unit), &none, h);
        let by_push = flow(runs, (zero, zero), &push, h);
        let by_rate = flow(runs, (zero, zero), &rate, h);
        let by_linear = flow(runs, (zero, zero), &linear, h);
        let by_square = flow(runs, (zero, zero), &square, h);
        let (mut forced, mut curves) = (Vec::with_capacity(steps as usize), Vec::with_capacity(steps as usize));
        for step in 0..steps {
            let u: [Vector<S>; TABLE_TERMS] = forcings.taylor_in(h * f64::from(step), h, runs.per_mass);
            let (xs, vs) = flow(runs, (zero, zero), &u, h);
            forced.push(Forced { x: places::<S, K>(&xs), v_end: value_at(&vs, 1.0), last: value_at(&u, 1.0) });
            curves.push((short(&(xs, vs)), cut(&u)));
        }
        let nodes = Nodes::<K>::AT;
        let mut slide = [zero; 4];
        for (lane, slide) in slide.iter_mut().enumerate() {
            *slide = runs.sliding * part_of::<K>(lane) * h;
        }
        let alone: [_; WIDTH] = std::array::from_fn(|number| {
            let by_v = by_v.0.map(|c| c[number]);
            Nodes::<K>::answers(|since| polynomial::value(&by_v, since))
        });
        let mut kick = [[zero; 4]; K];
        for (node, lanes) in kick.iter_mut().enumerate() {
            for (lane, answer) in lanes.iter_mut().enumerate().take(K + 1) {
                *answer = each(simd, |number| alone[number][node].lane(lane));
            }
        }
        let (mut kick_end, mut at_s, mut weights) = ([zero; K], [zero; K], [zero; K]);
        for (k, from) in nodes.into_iter().enumerate() {
            kick_end[k] = value_at(&by_v.1, 1.0 - from);
            at_s[k] = h * from;
            weights[k] = h * Nodes::<K>::WEIGHT[k];
        }
        Tables {
            h,
            x: By {
                x: places::<S, K>(&by_x.0),
                v: places::<S, K>(&by_v.0),
                push: places::<S, K>(&by_push.0),
                push_rate: places::<S, K>(&by_rate.0),
            },
            v_end: [value_at(&by_x.1, 1.0), value_at(&by_v.1, 1.0), value_at(&by_push.1, 1.0), value_at(&by_rate.1, 1.0)],
            slide,
            kick,
            weights,
            kick_end,
            at_s,
            by: [short(&by_x), short(&by_v), short(&by_push), short(&by_linear), short(&by_square)],
            forced,
            curves,
        }
    }

    /// Returns whole steps as one substep each.
    #[inline(always)]
    pub fn part(&self, runs: &Batch<S, K, N>, step: usize) -> Option<Substeps<S, N>> {
        let ((mut x, mut v), u) = *self.curves.get(step)?;
        let f = runs.friction_terms(self.h);
        let scales = [runs.x, runs.v, -runs.push * f[0], -runs.push * f[1], -runs.push * f[2]];
        for (by, scale) in self.by.iter().zip(scales) {
            for k in 0..N {
                x[k] += scale * by.0[k];
                v[k] += scale * by.1[k];
            }
        }
        Some(Substeps::new(self.h, (x, v), u, f))
    }
}

/// Computes the flow over a step from initial displacements and velocities under forcings.
#[inline(always)]
fn flow<S: Simd, const K: usize, const N: usize>(
    runs: &Batch<S, K, N>,
    from: (Vector<S>, Vector<S>),
    u: &[Vector<S>; TABLE_TERMS],
    h: Vector<S>,
) -> Series<S, TABLE_TERMS>
where
    Nodes<K>: Places,
{
    runs.simd.vectorize(
        #[inline(always)]
        || series((runs.damping, runs.stiffness), from, u, h),
    )
}

/// Returns the position of an evaluation point in a step from 0 to 1: a node, or the end.
#[inline(always)]
fn part_of<const K: usize>(lane: usize) -> f64 {
    if lane < K { place::<K>(lane) } else { 1.0 }
}

#[inline(always)]
fn value_at<S: Simd>(c: &[Vector<S>; TABLE_TERMS], s: f64) -> Vector<S> {
    let simd = c[0].simd;
    simd.vectorize(
        #[inline(always)]
        || value(c, all(simd, s)),
    )
}

#[inline(always)]
fn places<S: Simd, const K: usize>(c: &[Vector<S>; TABLE_TERMS]) -> [Vector<S>; 4] {
    let mut out = [all(c[0].simd, 0.0); 4];
    for (lane, out) in out.iter_mut().enumerate().take(K + 1) {
        *out = value_at(c, part_of::<K>(lane));
    }
    out
}

/// Returns the first coefficients.
#[inline(always)]
fn cut<S: Simd, const N: usize>(c: &[Vector<S>; TABLE_TERMS]) -> [Vector<S>; N] {
    let mut out = [c[0]; N];
    out.copy_from_slice(&c[..N]);
    out
}

#[inline(always)]
fn short<S: Simd, const N: usize>(series: &Series<S, TABLE_TERMS>) -> Series<S, N> {
    (cut(&series.0), cut(&series.1))
}
