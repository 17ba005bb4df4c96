//! The fast step of [`linexp`](super): the flow over each step of a period is computed once, as a
//! table.
//!
//! A step then takes a few multiplications for the motion, and one exponential per node and one for
//! the end, all computed together.

use super::decay::decay;
use super::exact_step::{Exact, PASSES, SMALL_EXPONENT};
use super::quadrature::Nodes;
use super::simd_nodes::{Lanes, Places, SimdNodes, combine, place};
use super::substep::Substep;
use crate::method::oscillator::Oscillator;
use crate::method::polynomial::{slope, value};
use crate::problem::Problem;
use crate::timeline::Stretch;

/// Flow over the steps of one whole piece of a periodic forcing. Of the lanes the first K are the
/// nodes, the others the end.
pub(super) struct Table<const K: usize, const N: usize>
where
    Nodes<K>: Places,
{
    h: f64,
    /// Displacement per unit of initial displacement, velocity, acceleration and rate of the
    /// acceleration.
    x: By<Lanes<K>>,
    /// Velocity at the end, from the same four quantities.
    v_end: [f64; 4],
    /// Slip by sliding alone, m.
    slide: Lanes<K>,
    /// Displacement in each lane from a kick at each node.
    kick: [Lanes<K>; K],
    /// Kick of each node per unit of acceleration, s.
    weights: Lanes<K>,
    /// Velocity at the end from a kick at each node.
    kick_end: [f64; K],
    /// Times of the nodes, s.
    at_s: Lanes<K>,
    /// Motion as a polynomial, from displacement, velocity, and the first three terms of friction.
    by: [Series<N>; 5],
    /// Contribution of the forcing, step by step.
    forced: Vec<Forced<Lanes<K>, N>>,
}

/// Coefficients of displacement and velocity over a step.
type Series<const N: usize> = ([f64; N], [f64; N]);

/// Lanes for each quantity that contributes to the displacement.
pub(super) struct By<L> {
    x: L,
    v: L,
    push: L,
    push_rate: L,
}

/// Contribution of the forcing within one step.
pub(super) struct Forced<L, const N: usize> {
    x: L,
    v_end: f64,
    /// Acceleration by the forcing at the end, m/s^2.
    last: f64,
    /// Motion by the forcing as a polynomial.
    series: Series<N>,
    /// Forcing as a polynomial.
    u: [f64; N],
}

/// Number of coefficients with which the tables are computed: exact to round-off for steps of up to
/// one radian.
pub(super) const TABLE_TERMS: usize = 24;

impl<const K: usize, const N: usize> Table<K, N>
where
    Nodes<K>: Places,
{
    pub fn new(oscillator: &Oscillator, problem: &Problem, stretch: &Stretch, steps: u32, h: f64) -> Self {
        let lanes = |c: &[f64; TABLE_TERMS]| Lanes::<K>::each(|lane| value(c, place::<K>(lane)));
        let (none, mut one, mut per_second) = ([0.0; TABLE_TERMS], [0.0; TABLE_TERMS], [0.0; TABLE_TERMS]);
        (one[0], per_second[1]) = (1.0, h);
        // A kinematic velocity is the forcing itself, so the displacement depends only on the
        // initial displacement.
        let from = |x: f64, v: f64, u: &[f64; TABLE_TERMS]| {
            if oscillator.kinematic {
                let mut still = none;
                still[0] = x;
                (still, none)
            } else {
                oscillator.series(x, v, u, h)
            }
        };
        let [by_x, by_v, by_push, by_rate] =
            [from(1.0, 0.0, &none), from(0.0, 1.0, &none), from(0.0, 0.0, &one), from(0.0, 0.0, &per_second)];
        let forced = (0..steps).map(|step| {
            let u: [f64; TABLE_TERMS] = oscillator.forcing(&stretch.forcing, f64::from(step) * h, h);
            let (xs, vs) = oscillator.series(0.0, 0.0, &u, h);
            let last = if oscillator.kinematic { slope(&u, 1.0) / h } else { value(&u, 1.0) };
            Forced { x: lanes(&xs), v_end: value(&vs, 1.0), last, series: short(&(xs, vs)), u: cut(&u) }
        });
        let nodes = Nodes::<K>::AT;
        let mut square = none;
        square[2] = 1.0;
        let by_square = from(0.0, 0.0, &square);
        let mut linear = none;
        linear[1] = 1.0;
        let by_linear = from(0.0, 0.0, &linear);
        Table {
            h,
            x: By { x: lanes(&by_x.0), v: lanes(&by_v.0), push: lanes(&by_push.0), push_rate: lanes(&by_rate.0) },
            v_end: [&by_x, &by_v, &by_push, &by_rate].map(|by| value(&by.1, 1.0)),
            slide: Lanes::<K>::each(|lane| problem.sliding_m_per_s * place::<K>(lane) * h),
            kick: Nodes::<K>::answers(|since| value(&by_v.0, since)),
            weights: Nodes::<K>::weights(h),
            kick_end: nodes.map(|from| value(&by_v.1, 1.0 - from)),
            at_s: Lanes::<K>::each(|lane| place::<K>(lane) * h),
            by: [&by_x, &by_v, &by_push, &by_linear, &by_square].map(short),
            forced: forced.collect(),
        }
    }

    /// Returns a whole step as one substep of the exact step, if a substep may be that long.
    pub fn part(&self, run: &Exact<K, N>, step: usize) -> Option<Substep<N>> {
        let forced = self.forced.get(step).filter(|_| self.h <= run.longest())?;
        let f = run.friction_terms(self.h);
        let scales = [run.x, run.v, -run.push * f[0], -run.push * f[1], -run.push * f[2]];
        let (mut x, mut v) = forced.series;
        for (by, scale) in self.by.iter().zip(scales) {
            for k in 0..N {
                x[k] += scale * by.0[k];
                v[k] += scale * by.1[k];
            }
        }
        Some(Substep::new(self.h, (x, v), forced.u, f))
    }
}

/// Returns the first coefficients.
fn cut<const N: usize>(c: &[f64; TABLE_TERMS]) -> [f64; N] {
    std::array::from_fn(|k| c[k])
}

fn short<const N: usize>(series: &Series<TABLE_TERMS>) -> Series<N> {
    (cut(&series.0), cut(&series.1))
}

/// Computes one step from the tables. Does nothing and returns `false` if the step has a reversal
/// or is steep.
///
/// The motion is computed with the initial friction and its slope; the kicks contain the rest.
/// Kicks are so small that the exponential for the friction can be evaluated before they are known,
/// and corrected to second order.
#[inline]
pub(super) fn fast_step<const K: usize, const N: usize>(run: &mut Exact<K, N>, table: &Table<K, N>, step: usize) -> bool
where
    Nodes<K>: Places,
{
    let all = Lanes::<K>::all;
    let end = Lanes::<K>::END;
    let Some(forced) = table.forced.get(step) else { return false };
    let (x, v, s) = (run.x, run.v, run.sense);
    let excess = run.f - s;
    let steep = run.per_metre * s;
    let rate = run.here.slope;
    let (push, push_rate) = (run.push * run.f, run.push * rate);
    let [by_x, by_v, by_push, by_rate] = table.v_end;
    let v_free = by_x * x + by_v * v + forced.v_end - by_push * push - by_rate * push_rate;
    if (run.sliding + run.sign * v_free) * s < 0.0 {
        return false;
    }
    let pushed = table.x.push * all(push) + table.x.push_rate * all(push_rate);
    let there = table.x.x * all(x) + table.x.v * all(v) + forced.x - pushed;
    let slips = table.slide + (there - all(x)) * all(run.sign);
    let exponents = slips * all(steep);
    let decays = decay(exponents);
    // Kicks set the slip back by so little that the exponential needs only a second-order
    // correction.
    let force = |late: Lanes<K>| all(s) + all(excess) * decays * (all(1.0) + late * (all(1.0) + late * all(0.5)));
    let straight = all(run.f) + all(rate) * table.at_s;
    let weights = table.weights * all(run.push);
    let mut forces = all(s) + all(excess) * decays;
    let mut kicks = (forces - straight) * weights;
    let mut back = combine(kicks, &table.kick);
    for _ in 1..PASSES {
        forces = force(back * all(steep * run.sign));
        kicks = (forces - straight) * weights;
        back = combine(kicks, &table.kick);
    }
    let back = back.lane(end);
    let late = back * (steep * run.sign);
    let f_end = s + excess * decays.lane(end) * (1.0 + late * (1.0 + late * 0.5));
    let x_end = there.lane(end) - back;
    let kicks: [f64; K] = std::array::from_fn(|lane| kicks.lane(lane));
    let v_kicks: f64 = kicks.iter().zip(&table.kick_end).map(|(kick, by)| kick * by).sum();
    let v_end = v_free - v_kicks;
    let slip = slips.lane(end) - run.sign * back;
    let slip_velocity = run.sliding + run.sign * v_end;
    let a_end = run.sign * run.acceleration(forced.last, x_end, v_end, f_end);
    // A velocity that falls at the beginning and rises at the end may have dipped below zero in
    // between.
    let dips = run.a * s < 0.0 && a_end * s > 0.0;
    let too_steep = exponents.lane(end) > run.steepest && excess.abs() > run.saturated;
    if slip_velocity * s < 0.0 || dips || too_steep || late.abs() > SMALL_EXPONENT {
        return false;
    }
    (run.x, run.v) = (x_end, v_end);
    let forces = std::array::from_fn(|lane| forces.lane(lane));
    run.add_friction(table.h, &forces, (f_end, slip_velocity, a_end), slip);
    true
}
