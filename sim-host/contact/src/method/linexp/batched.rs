//! Batched runs of many contacts, eight at a time in the lanes of SIMD registers. Each is bit for
//! bit equal to a single run.
//!
//! ```text
//! problems --> groups of eight with equal stretches --> Batch (state, one vector per quantity)
//!                                             fast step   all at once, by common tables
//!                                             exact step  contacts with a reversal or a steep law, each in its own parts
//!              the others ---------------> one by one
//! ```
//!
//! The lanes perform the operations of the scalar run in the same order, so the result has the same
//! bits for every instruction set. The instruction set is chosen at run time. A batch takes as many
//! exact steps as its worst contact, and one whenever any contact reverses. So neighbours in a map,
//! which reverse at nearly the same time, gain most.
#![cfg_attr(
    not(any(target_arch = "x86_64", target_arch = "aarch64")),
    expect(dead_code, unused_variables, reason = "without such SIMD instructions nothing is batched")
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
use super::{Options, PLAIN_TERMS};
use crate::problem::{Law, Motion, Problem};
use crate::waveform::Shape;
use run::Outcome;
use vector::WIDTH;

/// Runs problems of Dahl friction as [`run`](super::run) does without the energies; `pause` is
/// called from time to time.
pub fn run_batched(problems: &[&Problem], steps_per_period: u32, order: u32, pause: &dyn Fn()) -> Vec<Outcome> {
    run_at(Level::new(), problems, steps_per_period, order, pause)
}

/// Runs problems with the instructions of a level.
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

/// Runs up to eight problems in one batch; `None` if they cannot be batched.
fn chunk<const K: usize>(level: Level, problems: &[&Problem], steps_per_period: u32, pause: &dyn Fn()) -> Option<Vec<Outcome>>
where
    Nodes<K>: Places,
{
    if problems.len() < 2 || !problems.iter().all(|problem| can_be_batched(problem)) {
        return None;
    }
    let last = *problems.last()?;
    let eight: [&Problem; WIDTH] = std::array::from_fn(|number| problems.get(number).copied().unwrap_or(last));
    let alone = eight.map(|problem| Exact::<K, PLAIN_TERMS>::new(problem, stiffness(problem), steps_per_period, Options::Plain));
    at(level, &eight, problems.len(), alone, steps_per_period, pause)
}

/// Runs a batch with the widest instructions of a level: AVX-512, AVX2, or the baseline of the
/// architecture.
fn at<const K: usize>(
    level: Level,
    problems: &[&Problem; WIDTH],
    count: usize,
    alone: [Exact<K, PLAIN_TERMS>; WIDTH],
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
    // Without such SIMD instructions batches gain nothing.
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    return None;
}

fn with<S: Simd, const K: usize>(
    simd: S,
    problems: &[&Problem; WIDTH],
    count: usize,
    alone: [Exact<K, PLAIN_TERMS>; WIDTH],
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

/// Returns `true` if a problem can be batched: an oscillator with Dahl friction under one load and
/// a periodic forcing.
pub fn can_be_batched(problem: &Problem) -> bool {
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
