//! The same contact in time steps, by return mapping: the reference for the arcs.
//!
//! ```text
//! f = min(f + kx v dt, mu N)       elastic predictor, frictional corrector (J. C. Simo, T. J. R. Hughes, *Computational Inelasticity*, 1998, ch. 1)
//! ```
//!
//! No event is located: sticking results from the steps alone. The method is of second order in the
//! step, but irregular, because the contact begins to stick and to slip anywhere within a step. The
//! spread of runs with three numbers of steps without a common grid is the uncertainty of a mean.
//! The mean position under a held load is found by bisection, from the mean force of the steps.

use std::f64::consts::TAU;

use super::{CompliantProblem, Press};

/// Means over a steady period from time steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteppedMeans {
    /// Mean friction over mu times the mean normal force.
    pub coefficient_ratio: f64,
    /// Mean friction, N.
    pub friction_n: f64,
    /// Fraction of the period in which the contact sticks, to one step.
    pub stick_share: f64,
    /// Uncertainty of `coefficient_ratio`: the spread of runs with other steps, or the second-order
    /// error for the number of steps in contact, if that is larger.
    pub unknown: f64,
}

/// Steps through a period from the deepest indentation, starting in slip, and averages over the
/// next one. Uses `steps`, 4/3 as many and twice as many.
pub fn solve(problem: &CompliantProblem, steps: u32) -> SteppedMeans {
    let [coarse, middle, fine] = [steps, steps + steps / 3, 2 * steps].map(|steps| run(problem, steps));
    let ratios = [&coarse, &middle, &fine].map(|run| run.coefficient_ratio);
    let spread = ratios.into_iter().fold(f64::MIN, f64::max) - ratios.into_iter().fold(f64::MAX, f64::min);
    // Three runs may agree by chance, especially if contact is short.
    let unknown = spread.max(f64::from(fine.touching).powi(-2));
    SteppedMeans {
        coefficient_ratio: fine.coefficient_ratio,
        friction_n: fine.friction_n,
        stick_share: fine.stick_share,
        unknown,
    }
}

/// Result of a run.
struct Run {
    coefficient_ratio: f64,
    friction_n: f64,
    stick_share: f64,
    /// Number of steps in contact.
    touching: u32,
}

fn run(problem: &CompliantProblem, steps: u32) -> Run {
    let cosines: Vec<f64> = (0..steps).map(|step| (TAU * f64::from(step) / f64::from(steps)).cos()).collect();
    let force = |place_m: f64, cosine: f64| problem.normal_n_per_m * (place_m + problem.amplitude_m * cosine).max(0.0);
    let mean = |place_m: f64| cosines.iter().map(|&cosine| force(place_m, cosine)).sum::<f64>() / f64::from(steps);
    let place_m = match problem.press {
        Press::Indentation(indentation_m) => indentation_m,
        Press::Load(normal_n) => {
            let top_m = normal_n / problem.normal_n_per_m;
            let (mut low, mut high) = (-problem.amplitude_m, top_m);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if mean(middle) < normal_n { low = middle } else { high = middle }
            }
            high
        }
    };
    let loaded_n = problem.tangential_n_per_m * problem.sliding_m_per_s / (problem.frequency_hz * f64::from(steps));
    let mut before_m = place_m + problem.amplitude_m;
    let mut friction_n = problem.mu * force(place_m, 1.0);
    let (mut sum_n, mut stuck, mut touching) = (0.0, 0, 0u32);
    for period in 0..2 {
        for &cosine in cosines.iter().skip(1).chain(cosines.first()) {
            let now_m = place_m + problem.amplitude_m * cosine;
            // If contact begins within a step, the spring is loaded only for the rest of it.
            let part = if before_m < 0.0 && now_m > 0.0 { now_m / (now_m - before_m) } else { 1.0 };
            let (predicted_n, limit_n) = (friction_n + loaded_n * part, problem.mu * force(place_m, cosine));
            before_m = now_m;
            friction_n = predicted_n.min(limit_n);
            if period == 1 {
                sum_n += friction_n;
                stuck += u32::from(predicted_n < limit_n);
                touching += u32::from(now_m > 0.0);
            }
        }
    }
    let friction_n = sum_n / f64::from(steps);
    Run {
        coefficient_ratio: friction_n / (problem.mu * mean(place_m)),
        friction_n,
        stick_share: f64::from(stuck) / f64::from(steps),
        touching,
    }
}
