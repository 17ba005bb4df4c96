//! Runs of many contacts at once, eight side by side in the lanes of SIMD registers: each bit for bit the run that it is alone.
//!
//! ```text
//! problems --> eights of like stretches --> Abreast (state, number by number)
//!                                             fast step   all at once, by tables of all
//!                                             exact step  those with a reversal or a steep law, each in parts of its own
//!              the others ---------------> one by one
//! ```
//!
//! The lanes do the operations of the scalar run in the same order, so what comes out is the same bits whatever the instruction set, which
//! is chosen at run time. Contacts side by side cost as many exact steps as the one with most, and one wherever any of them reverses: so
//! neighbours of a map, which reverse at nearly the same time, gain most.
#![cfg_attr(
    not(any(target_arch = "x86_64", target_arch = "aarch64")),
    expect(dead_code, unused_variables, reason = "without instructions of that kind nothing runs side by side")
)]

mod decay;
mod exact_step;
mod fast_step;
mod forcing;
mod reversal;
mod run;
mod state;
mod table;
mod turn;
mod vector;

use fearless_simd::{Level, Simd};

use super::exact_step::Exact;
use super::quadrature::Nodes;
use super::simd_nodes::Places;
use super::{Options, PLAIN};
use crate::problem::{Law, Motion, Problem};
use crate::waveform::Shape;
use run::Outcome;
use vector::WIDTH;

/// Runs problems of Dahl friction as [`run`](super::run) does without the energies; `pause` is called now and then.
pub fn run_abreast(problems: &[&Problem], steps_per_period: u32, order: u32, pause: &dyn Fn()) -> Vec<Outcome> {
    run_at(Level::new(), problems, steps_per_period, order, pause)
}

/// The same with the instructions of a level.
fn run_at(level: Level, problems: &[&Problem], steps_per_period: u32, order: u32, pause: &dyn Fn()) -> Vec<Outcome> {
    let mut out = Vec::with_capacity(problems.len());
    for eight in problems.chunks(WIDTH) {
        let together = match order {
            2 => chunk::<1>(level, eight, steps_per_period, pause),
            4 => chunk::<2>(level, eight, steps_per_period, pause),
            6 => chunk::<3>(level, eight, steps_per_period, pause),
            _ => None,
        };
        match together {
            Some(outcomes) => out.extend(outcomes),
            None => out.extend(eight.iter().map(|problem| {
                pause();
                super::run(problem, steps_per_period, order, Options::Plain, &mut |_| ())
            })),
        }
    }
    out
}

/// Up to eight side by side; none if they cannot.
fn chunk<const K: usize>(level: Level, problems: &[&Problem], steps_per_period: u32, pause: &dyn Fn()) -> Option<Vec<Outcome>>
where
    Nodes<K>: Places,
{
    if problems.len() < 2 || !problems.iter().all(|problem| is_for_lanes(problem)) {
        return None;
    }
    let last = *problems.last()?;
    let eight: [&Problem; WIDTH] = std::array::from_fn(|number| problems.get(number).copied().unwrap_or(last));
    let alone = eight.map(|problem| Exact::<K, PLAIN>::new(problem, stiffness(problem), steps_per_period, Options::Plain));
    at(level, &eight, problems.len(), alone, steps_per_period, pause)
}

/// The run with the widest instructions of a level: AVX-512, AVX2, or what every machine of its kind has.
fn at<const K: usize>(
    level: Level,
    problems: &[&Problem; WIDTH],
    count: usize,
    alone: [Exact<K, PLAIN>; WIDTH],
    steps_per_period: u32,
    pause: &dyn Fn(),
) -> Option<Vec<Outcome>>
where
    Nodes<K>: Places,
{
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(simd) = level.as_avx512() {
            return with(simd, problems, count, alone, steps_per_period, pause);
        }
        if let Some(simd) = level.as_avx2() {
            return with(simd, problems, count, alone, steps_per_period, pause);
        }
        with(level.as_sse2()?, problems, count, alone, steps_per_period, pause)
    }
    #[cfg(target_arch = "aarch64")]
    return with(level.as_neon()?, problems, count, alone, steps_per_period, pause);
    // Without instructions of that kind lanes gain nothing.
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    return None;
}

fn with<S: Simd, const K: usize>(
    simd: S,
    problems: &[&Problem; WIDTH],
    count: usize,
    alone: [Exact<K, PLAIN>; WIDTH],
    steps_per_period: u32,
    pause: &dyn Fn(),
) -> Option<Vec<Outcome>>
where
    Nodes<K>: Places,
{
    simd.vectorize(
        #[inline(always)]
        || run::run(simd, problems, count, alone, steps_per_period, pause),
    )
}

/// Whether the lanes can do a problem: an oscillator with Dahl friction under one load and a periodic forcing.
pub fn is_for_lanes(problem: &Problem) -> bool {
    let periodic =
        matches!(problem.waveform.shape(), Shape::Sine | Shape::Square | Shape::Sawtooth | Shape::Triangle | Shape::Still);
    let oscillates = matches!(problem.motion, Motion::Sdof { .. });
    oscillates && periodic && matches!(problem.law, Law::Dahl { .. }) && problem.load_steps.is_empty()
}

fn stiffness(problem: &Problem) -> f64 {
    problem.law.stiffness_n_per_m().unwrap_or(0.0)
}

#[cfg(test)]
mod tests;
