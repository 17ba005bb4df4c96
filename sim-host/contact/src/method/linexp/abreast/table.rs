//! The flows of eight contacts over each step of a period: [`Table`](super::super::fast_step::Table) abreast, and made abreast.

use fearless_simd::Simd;

use super::super::fast_step::EXACT;
use super::super::quadrature::Nodes;
use super::super::simd_nodes::{Places, place};
use super::exact_step::{Substeps, series};
use super::forcing::Forcings;
use super::state::Abreast;
use super::vector::{Each, Which, all, value};

/// With the names of [`Table`](super::super::fast_step::Table). Places are the nodes, and then the end.
pub(super) struct Tables<S: Simd, const K: usize, const N: usize> {
    pub h: Each<S>,
    pub x: By<S>,
    pub v_end: [Each<S>; 4],
    pub slide: [Each<S>; 4],
    pub kick: [[Each<S>; K]; 4],
    pub kick_end: [Each<S>; K],
    pub at_s: [Each<S>; K],
    by: [Series<S, N>; 5],
    pub forced: Vec<Forced<S>>,
    /// What the forcing adds as polynomials, and the forcing itself: apart, as few steps need them.
    curves: Vec<(Series<S, N>, [Each<S>; N])>,
}

/// Coefficients of displacement and velocity over a step.
type Series<S, const N: usize> = ([Each<S>; N], [Each<S>; N]);

/// Displacements at the places, by what they come from.
pub(super) struct By<S: Simd> {
    pub x: [Each<S>; 4],
    pub v: [Each<S>; 4],
    pub push: [Each<S>; 4],
    pub push_rate: [Each<S>; 4],
}

/// What the forcing adds within one step.
pub(super) struct Forced<S: Simd> {
    pub x: [Each<S>; 4],
    pub v_end: Each<S>,
    pub last: Each<S>,
}

impl<S: Simd, const K: usize, const N: usize> Tables<S, K, N>
where
    Nodes<K>: Places,
{
    #[inline(always)]
    pub fn new(runs: &Abreast<S, K, N>, forcings: &Forcings<S>, on: Which<S>, steps: u32, h: Each<S>) -> Self {
        let simd = runs.simd;
        let oscillator = (runs.damping, runs.stiffness);
        let (zero, unit) = (all(simd, 0.0), all(simd, 1.0));
        let none = [zero; EXACT];
        let with = |k: usize, value: Each<S>| {
            let mut c = none;
            c[k] = value;
            c
        };
        let at = |lane: usize| if lane < K { place::<K>(lane) } else { 1.0 };
        let value_at = |c: &[Each<S>; EXACT], s: f64| {
            simd.vectorize(
                #[inline(always)]
                || value(c, all(simd, s)),
            )
        };
        let places = |c: &[Each<S>; EXACT]| -> [Each<S>; 4] {
            std::array::from_fn(|lane| if lane <= K { value_at(c, at(lane)) } else { zero })
        };
        let from = |x: Each<S>, v: Each<S>, u: &[Each<S>; EXACT]| {
            simd.vectorize(
                #[inline(always)]
                || series(oscillator, (x, v), u, h),
            )
        };
        let [by_x, by_v, by_push, by_rate] =
            [from(unit, zero, &none), from(zero, unit, &none), from(zero, zero, &with(0, unit)), from(zero, zero, &with(1, h))];
        let [by_linear, by_square] = [1, 2].map(|k| from(zero, zero, &with(k, unit)));
        let (mut forced, mut curves) = (Vec::with_capacity(steps as usize), Vec::with_capacity(steps as usize));
        for step in 0..steps {
            let u: [Each<S>; EXACT] = forcings.taylor_in(h * f64::from(step), h, runs.per_mass, on);
            let (xs, vs) = from(zero, zero, &u);
            forced.push(Forced { x: places(&xs), v_end: value_at(&vs, 1.0), last: value_at(&u, 1.0) });
            curves.push((short(&(xs, vs)), cut(&u)));
        }
        let nodes = Nodes::<K>::AT;
        let kick = |from: f64, to: f64| if to > from { value_at(&by_v.0, to - from) } else { zero };
        Tables {
            h,
            x: By { x: places(&by_x.0), v: places(&by_v.0), push: places(&by_push.0), push_rate: places(&by_rate.0) },
            v_end: [&by_x, &by_v, &by_push, &by_rate].map(|by| value_at(&by.1, 1.0)),
            slide: std::array::from_fn(|lane| runs.sliding * at(lane) * h),
            kick: std::array::from_fn(|lane| nodes.map(|from| kick(from, at(lane)))),
            kick_end: nodes.map(|from| value_at(&by_v.1, 1.0 - from)),
            at_s: nodes.map(|s| h * s),
            by: [&by_x, &by_v, &by_push, &by_linear, &by_square].map(short),
            forced,
            curves,
        }
    }

    /// Whole steps as one substep each.
    #[inline(always)]
    pub fn part(&self, runs: &Abreast<S, K, N>, step: usize) -> Option<Substeps<S, N>> {
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

/// The first coefficients.
#[inline(always)]
fn cut<S: Simd, const N: usize>(c: &[Each<S>; EXACT]) -> [Each<S>; N] {
    std::array::from_fn(|k| c[k])
}

#[inline(always)]
fn short<S: Simd, const N: usize>(series: &Series<S, EXACT>) -> Series<S, N> {
    (cut(&series.0), cut(&series.1))
}
