//! Cost of `auto`, from the question to the answer, over the cheapest setting of a fixed grid that
//! meets the tolerance together with all finer ones.

use std::hint::black_box;
use std::time::{Duration, Instant};

use contact::tally::Ratios;
use contact::{Method, Numerics, Problem, linexp, solve_unwatched};

use super::ContactRuns;
use super::judged::Truth;

/// Numbers of steps a period in the grid.
const STEPS: [u32; 18] = [4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024, 2048];
/// Number of rounds; the shortest counts.
const ROUNDS: usize = 3;

/// The cost of one question.
pub struct Cost {
    /// Number of the contact.
    pub number: u32,
    /// Length of the run, drive periods.
    pub periods: f64,
    /// Vibration amplitude in Dahl lengths.
    pub kappa: f64,
    /// Requested tolerance.
    pub tolerance: f64,
    /// Cheapest setting: order, steps a period.
    pub best: (u32, u32),
    /// Time of `auto` over that of the best setting.
    pub ratio: f64,
    /// Setting that `auto` has chosen.
    pub how: String,
}

/// Measures the costs of contacts at all their tolerances.
pub fn measure<'a>(set: impl Iterator<Item = &'a ContactRuns>) -> Vec<Cost> {
    set.flat_map(|tried| tried.truth.iter().flat_map(move |truth| measure_contact(tried, truth))).collect()
}

fn measure_contact(tried: &ContactRuns, truth: &Truth) -> Vec<Cost> {
    let problem = &tried.contact.problem;
    let mut grid = Vec::new();
    for order in linexp::ORDERS {
        // From fine to coarse, with the largest error of a setting and all finer ones.
        let mut worst = 0.0f64;
        for steps in STEPS.into_iter().rev() {
            let friction = friction_ratio(problem, (order, steps));
            worst = worst.max(friction.map_or(f64::INFINITY, |friction| (friction - truth.friction).abs()));
            grid.push(((order, steps), worst));
        }
    }
    let best = |tolerance: f64| {
        // Finds the coarsest sufficient setting of each order, then the cheapest of them.
        let coarsest = linexp::ORDERS.into_iter().filter_map(|order| {
            grid.iter().filter(|((of, _), worst)| *of == order && *worst <= tolerance).map(|(setting, _)| *setting).next_back()
        });
        let timed = coarsest.map(|setting| (setting, shortest(&mut || _ = black_box(friction_ratio(problem, setting)))));
        timed.min_by_key(|(_, time)| *time)
    };
    let cost = |answer: &super::Judged| {
        let (setting, time) = best(answer.tolerance)?;
        let numerics = Numerics { tolerance: answer.tolerance, energies: false, ..Numerics::default() };
        let auto = shortest(&mut || _ = black_box(solve_unwatched(problem, &numerics, &|| ())));
        Some(Cost {
            number: tried.contact.number,
            periods: problem.duration_s * problem.waveform.frequency_hz(),
            kappa: problem.kappa(),
            tolerance: answer.tolerance,
            best: setting,
            ratio: auto.as_secs_f64() / time.as_secs_f64(),
            how: answer.how.clone(),
        })
    };
    tried.answers.iter().filter_map(cost).collect()
}

fn friction_ratio(problem: &Problem, (order, steps): (u32, u32)) -> Option<f64> {
    let tally = Method::Linexp.run(problem, (steps, Some(order)), false, &mut |_| ()).ok()?;
    Some(Ratios::of(problem, &tally).friction)
}

fn shortest(question: &mut dyn FnMut()) -> Duration {
    let mut timed = || {
        let began = Instant::now();
        question();
        began.elapsed()
    };
    (0..ROUNDS).map(|_| timed()).min().unwrap_or_default()
}
