//! The batched fast step of eight contacts; see [`fast_step`](super::super::fast_step).

use fearless_simd::{Simd, SimdBase, SimdMask};

use super::super::exact_step::{PASSES, SMALL_EXPONENT};
use super::super::quadrature::Nodes;
use super::super::simd_nodes::Places;
use super::exact_step::decay_at;
use super::state::Batch;
use super::table::Tables;
use super::vector::{Mask, Vector, all, put};

/// Computes one step from the tables for the contacts in `on`; returns those for which it
/// succeeded. Contacts with a reversal or a steep step stay unchanged.
#[inline(always)]
pub(super) fn fast_step<S: Simd, const K: usize, const N: usize>(
    runs: &mut Batch<S, K, N>,
    table: &Tables<S, K, N>,
    step: usize,
    on: Mask<S>,
) -> Mask<S>
where
    Nodes<K>: Places,
{
    let simd = runs.simd;
    let none = on & !on;
    let Some(forced) = table.forced.get(step) else { return none };
    let (zero, one) = (all(simd, 0.0), all(simd, 1.0));
    let (x, v, s) = (runs.x, runs.v, runs.sense);
    let excess = runs.f - s;
    let steep = runs.per_metre * s;
    let rate = runs.here.slope;
    let (push, push_rate) = (runs.push * runs.f, runs.push * rate);
    let [by_x, by_v, by_push, by_rate] = table.v_end;
    let v_free = by_x * x + by_v * v + forced.v_end - by_push * push - by_rate * push_rate;
    let on = on & !((runs.sliding + runs.sign * v_free) * s).simd_lt(0.0);
    if !on.any_true() {
        return none;
    }
    let mut there = [zero; 4];
    let mut slips = [zero; 4];
    let mut exponents = [zero; 4];
    for lane in 0..=K {
        let pushed = table.x.push[lane] * push + table.x.push_rate[lane] * push_rate;
        there[lane] = table.x.x[lane] * x + table.x.v[lane] * v + forced.x[lane] - pushed;
        slips[lane] = table.slide[lane] + (there[lane] - x) * runs.sign;
        exponents[lane] = slips[lane] * steep;
    }
    let decays = decay_at::<S, K>(&exponents, on);
    let late_per_m = steep * runs.sign;
    let (mut kicks, mut forces) = ([zero; K], [zero; K]);
    for pass in 0..PASSES {
        let before = kicks;
        for i in 0..K {
            forces[i] = s + excess * decays[i];
            if pass > 0 {
                let late = combine(&before, &table.kick, i) * late_per_m;
                forces[i] = s + excess * decays[i] * (one + late * (one + late * 0.5));
            }
            kicks[i] = (forces[i] - (runs.f + rate * table.at_s[i])) * (table.weights[i] * runs.push);
        }
    }
    let back = combine(&kicks, &table.kick, K);
    let late = back * late_per_m;
    let f_end = s + excess * decays[K] * (one + late * (one + late * 0.5));
    let x_end = there[K] - back;
    let v_end = v_free - sum(&kicks, &table.kick_end);
    let slip = slips[K] - runs.sign * back;
    let slip_velocity = runs.sliding + runs.sign * v_end;
    let a_end = runs.sign * runs.acceleration(forced.last, x_end, v_end, f_end);
    let dips = (runs.a * s).simd_lt(0.0) & (a_end * s).simd_gt(0.0);
    let too_steep = exponents[K].simd_gt(runs.steepest) & excess.abs().simd_gt(runs.saturated);
    let done = on & !((slip_velocity * s).simd_lt(0.0) | dips | too_steep | late.abs().simd_gt(SMALL_EXPONENT));
    put(&mut runs.x, done, x_end);
    put(&mut runs.v, done, v_end);
    runs.add_friction(done, table.h, &forces, (f_end, slip_velocity, a_end), slip);
    done
}

/// Returns the sum of kicks times their responses.
#[inline(always)]
fn sum<S: Simd, const K: usize>(kicks: &[Vector<S>; K], by: &[Vector<S>; K]) -> Vector<S> {
    let mut sum = all(by[0].simd, -0.0);
    for (kick, by) in kicks.iter().zip(by) {
        sum += *kick * *by;
    }
    sum
}

/// Returns the displacement at an evaluation point: the sum of kicks times their answers there.
#[inline(always)]
pub(super) fn combine<S: Simd, const K: usize>(kicks: &[Vector<S>; K], answers: &[[Vector<S>; 4]; K], lane: usize) -> Vector<S> {
    let mut sum = all(kicks[0].simd, -0.0);
    for (kick, answers) in kicks.iter().zip(answers) {
        sum += *kick * answers[lane];
    }
    sum
}
