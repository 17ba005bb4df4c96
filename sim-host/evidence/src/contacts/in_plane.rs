//! The reference of bristles under a vibration at an angle: Taylor series of the slip, of its
//! magnitude and of the bristle force, step by step.
//!
//! ```text
//! S = w_x^2 + w_y^2     r = sqrt S        2 r_0 r_k = S_k - sum r_i r_(k-i)
//! E = exp(-S / Vs^2)    k E_k = sum i a_i E_(k-i),  a = -S / Vs^2
//! q = (Kt / Fc) r / (1 + (Fs/Fc - 1) E)
//! y' = p - q y          (k + 1) y_(k+1) = p_k - sum q_i y_(k-i)
//! ```
//!
//! It shares only the timeline with `auto`: no node, panel or matrix. Steps are explicit, so stiff
//! bristles need many.

use contact::plane::Direction;
use contact::timeline::{Stretch, Timeline};
use contact::{Law, Problem};

/// Orders of the two runs, whose difference is the uncertainty of the reference.
const ORDERS: [usize; 2] = [32, 24];
/// Relative round-off of a mean.
const ROUND_OFF: f64 = 2e-14;
/// Largest number of steps of a stretch.
const MAX_STEPS: u32 = 4_000_000;

/// Returns the mean friction ratio and the difference of the two orders; `None` if a stretch takes
/// more than [`MAX_STEPS`] steps.
pub(super) fn truth(problem: &Problem, direction: Direction) -> Option<(f64, f64)> {
    let (fine, other) = (mean::<{ ORDERS[0] + 1 }>(problem, direction)?, mean::<{ ORDERS[1] + 1 }>(problem, direction)?);
    Some((fine, (fine - other).abs().max(ROUND_OFF * fine.abs().max(1.0))))
}

/// Effect of a stretch on the bristle force along the sliding, f = B / Fc:
/// `f1 = f0 + gained - lost f0`; and the integrals of f, s, and of the slip, m.
#[derive(Clone, Copy, Debug, Default)]
struct StretchEffect {
    lost: f64,
    gained: f64,
    of_start: f64,
    of_rest: f64,
    slip_m: f64,
}

fn mean<const N: usize>(problem: &Problem, direction: Direction) -> Option<f64> {
    let mut known: Vec<(usize, StretchEffect)> = Vec::new();
    let (mut force, mut open) = (problem.start.force_n / problem.coulomb_n, false);
    let (mut integral, mut slip_m, mut time_s, mut first) = (Sum::default(), Sum::default(), Sum::default(), force);
    for stretch in Timeline::new(problem) {
        if stretch.closes {
            break;
        }
        if stretch.opens {
            (open, first) = (true, force);
        }
        let again = stretch.template.and_then(|template| known.iter().find(|known| known.0 == template));
        let effect = match again {
            Some((_, effect)) => *effect,
            None => {
                let effect = effect::<N>(problem, direction, &stretch)?;
                known.extend(stretch.template.map(|template| (template, effect)));
                effect
            }
        };
        if open {
            integral.add(effect.of_start * force + effect.of_rest);
            slip_m.add(effect.slip_m);
            time_s.add(stretch.length_s);
        }
        force += effect.gained - effect.lost * force;
    }
    let (damping_s, viscous) = match problem.law {
        Law::Lugre { stiffness_n_per_m, sigma1, sigma2, .. } => (sigma1 / stiffness_n_per_m, sigma2 / problem.coulomb_n),
        _ => (0.0, 0.0),
    };
    Some((integral.total() + damping_s * (force - first) + viscous * slip_m.total()) / time_s.total())
}

/// A sum that keeps the error of each addition (Knuth 1998, *Seminumerical Algorithms*, 4.2.2,
/// theorem B): thousands of equal stretches round in the same direction.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    value: f64,
    error: f64,
}

impl Sum {
    fn add(&mut self, part: f64) {
        let next = self.value + part;
        let taken = next - self.value;
        self.error += (self.value - (next - taken)) + (part - taken);
        self.value = next;
    }

    fn total(self) -> f64 {
        self.value + self.error
    }
}

fn effect<const N: usize>(problem: &Problem, direction: Direction, stretch: &Stretch) -> Option<StretchEffect> {
    let sign = problem.sign.factor();
    let (stiffness, peak, stribeck) = match problem.law {
        Law::Dahl { stiffness_n_per_m } => (stiffness_n_per_m, 0.0, f64::INFINITY),
        Law::Lugre { stiffness_n_per_m, static_ratio, stribeck_m_per_s, .. } => {
            (stiffness_n_per_m, static_ratio - 1.0, stribeck_m_per_s)
        }
        Law::Coulomb => return None,
    };
    let gain = stiffness / problem.coulomb_n;
    let (mut effect, mut at_s, mut unit_s) = (StretchEffect::default(), 0.0, 1e-2 * stretch.length_s);
    let least_s = 1e-16 * stretch.length_s;
    // Steps this short cannot leap over a minimum that follows a growing slip.
    let most_s = 1.0 / (16.0 * stretch.fastest_hz);
    for _ in 0..MAX_STEPS {
        let left_s = stretch.length_s - at_s;
        if left_s <= 0.0 {
            return Some(effect);
        }
        let u = stretch.forcing.taylor_in::<N>(at_s, unit_s);
        let mut along = u.map(|u| sign * direction.along * u);
        along[0] += problem.sliding_m_per_s;
        let across = u.map(|u| sign * direction.across * u);
        let (one, other) = (product(&along, &along), product(&across, &across));
        let square: [f64; N] = std::array::from_fn(|k| one[k] + other[k]);
        let loss = loss(&square, gain, (peak, stribeck));
        // Parts of a unit force that are lost and gained from here on.
        let (mut lost, mut gained) = ([0.0; N], [0.0; N]);
        (lost[0], gained[0]) = (effect.lost, effect.gained);
        let (mut size, last) = (0.0f64, N - 1);
        for k in 0..last {
            let sum = |y: &[f64; N]| (0..=k).map(|i| loss[i] * y[k - i]).sum::<f64>();
            let over = unit_s / (k + 1) as f64;
            (lost[k + 1], gained[k + 1]) = ((loss[k] - sum(&lost)) * over, (gain * along[k] - sum(&gained)) * over);
        }
        for series in [&lost, &gained] {
            let of = |k: usize| series[k].abs().powf(1.0 / k as f64);
            size = size.max(of(last)).max(of(last - 1));
        }
        // The last terms must be below the round-off of one.
        let step = 1e-17f64.powf(1.0 / last as f64) / size.max(1e-300);
        if step < 0.05 && unit_s > least_s {
            unit_s *= (2.0 * step).max(1e-3);
            continue;
        }
        let step = step.min(to_the_least_slip(&square));
        let step_s = (step * unit_s).min(4.0 * unit_s).min(most_s).max(least_s).min(left_s);
        let part = step_s / unit_s;
        let integral = |series: &[f64; N]| {
            series.iter().enumerate().rev().fold(0.0, |sum, (k, value)| sum * part + value / (k + 1) as f64) * step_s
        };
        let value = |series: &[f64; N]| series.iter().rev().fold(0.0, |sum, value| sum * part + value);
        effect.of_start += step_s - integral(&lost);
        effect.of_rest += integral(&gained);
        effect.slip_m += integral(&along);
        (effect.lost, effect.gained) = (value(&lost), value(&gained));
        at_s = if step_s >= left_s { stretch.length_s } else { at_s + step_s };
        unit_s = step_s;
    }
    None
}

/// Returns half of the distance to the smallest slip, in steps of the series; no bound if the slip
/// grows. Far from a narrow minimum the magnitude of the slip, `sqrt((d - t)^2 + e^2)`, is a
/// straight line except for terms of e^2. A series would leap over the minimum and continue with
/// `d - t` below zero.
fn to_the_least_slip<const N: usize>(square: &[f64; N]) -> f64 {
    if square[1] < 0.0 { -square[0] / square[1] } else { f64::INFINITY }
}

fn product<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|k| (0..=k).map(|i| a[i] * b[k - i]).sum())
}

/// Computes q in 1/s from the square of the slip's magnitude.
fn loss<const N: usize>(square: &[f64; N], gain: f64, (peak, stribeck): (f64, f64)) -> [f64; N] {
    let mut size = [0.0; N];
    size[0] = square[0].sqrt();
    for k in 1..N {
        let sum: f64 = (1..k).map(|i| size[i] * size[k - i]).sum();
        size[k] = (square[k] - sum) / (2.0 * size[0]);
    }
    if peak == 0.0 {
        return size.map(|size| gain * size);
    }
    let exponent = square.map(|square| -square / (stribeck * stribeck));
    let mut limit = [0.0; N];
    limit[0] = exponent[0].exp();
    for k in 1..N {
        limit[k] = (1..=k).map(|i| i as f64 * exponent[i] * limit[k - i]).sum::<f64>() / k as f64;
    }
    limit = limit.map(|value| peak * value);
    limit[0] += 1.0;
    let mut loss = [0.0; N];
    for k in 0..N {
        let sum: f64 = (1..=k).map(|i| limit[i] * loss[k - i]).sum();
        loss[k] = (gain * size[k] - sum) / limit[0];
    }
    loss
}
