//! Starts of the fits of the contact models, over the stiffnesses and Stribeck velocities that the
//! log resolves.

use super::log::Log;
use super::models::Model;
use report::statistics::{ascending, quantile};

/// Number of the best starts, which are always followed.
const BEST_STARTS: usize = 3;
/// Tried Stribeck velocities, relative to the highest velocity.
const STRIBECK_REL: [f64; 6] = [0.03, 0.06, 0.12, 0.25, 0.5, 0.9];
/// Slip after a reversal beyond which a contact slides, in units of friction over stiffness.
const PRESLIDING_LENGTHS: f64 = 4.0;
/// Minimum number of sliding samples for an estimate from them.
const MIN_SLIDING_SAMPLES: usize = 20;
/// Number of tried stiffnesses.
const STIFFNESS_COUNT: u32 = 12;

/// Returns the starts that are followed: the best ones, and the best one of each Stribeck velocity
/// and each stiffness. Each of these has its own minimum, and the best minimum need not have the
/// best start.
pub(super) fn followed(
    model: Model,
    log: &Log,
    used: &[bool],
    baseline: usize,
    cost: impl Fn(&Vec<f64>) -> f64,
) -> Vec<Vec<f64>> {
    let parameters = model.parameters(baseline);
    let mut starts: Vec<(f64, Vec<f64>)> =
        all(model, log, used, baseline).into_iter().map(|start| (cost(&start), start)).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let own: Vec<usize> =
        (0..parameters.len()).filter(|at| matches!(parameters[*at].0, "stribeck_m_per_s" | "stiffness_n_per_m")).collect();
    let is_new = |at: usize, p: usize| starts[..at].iter().all(|(_, earlier)| earlier[p] != starts[at].1[p]);
    let is_followed = |at: &usize| *at < BEST_STARTS || own.iter().any(|p| is_new(*at, *p));
    (0..starts.len()).filter(is_followed).map(|at| starts[at].1.clone()).collect()
}

/// Returns starts over the range that the log resolves.
fn all(model: Model, log: &Log, used: &[bool], baseline: usize) -> Vec<Vec<f64>> {
    let of_used =
        |values: &[f64]| ascending(values.iter().zip(used).filter(|(_, used)| **used).map(|(v, _)| v.abs()).filter(|v| *v > 0.0));
    let at = |sorted: &[f64], part: f64| quantile(sorted, part).unwrap_or(1.0);
    let offset = if baseline > 0 { log.offset_n() } else { 0.0 };
    let friction: Vec<f64> = log.force_n.iter().map(|force| force - offset).collect();
    let (force, speed, slip) = (of_used(&friction), of_used(&log.velocity_m_per_s), of_used(&log.slip_m));
    let fc = at(&force, 0.5);
    let range: f64 = slip.iter().sum();
    // Steps around a reversal can be arbitrarily short.
    let (finest, coarsest) = (at(&slip, 0.05), 0.1 * range);
    let step = libm::pow((coarsest / finest).max(2.0), 1.0 / f64::from(STIFFNESS_COUNT - 1));
    let stiffness = (0..STIFFNESS_COUNT).map(|n| fc / (finest * libm::pow(step, f64::from(n))));
    let stiffness: Vec<f64> = if model.has_spring() { stiffness.collect() } else { vec![1.0] };
    let fastest = speed.last().copied().unwrap_or(1.0);
    let beyond = since_reversal(log);
    // Estimated from samples well beyond the presliding; a guess is added in case they mislead.
    let steady_values = |kt: f64| -> Vec<[f64; 4]> {
        if !model.falls() {
            return vec![[fc, 0.0, fastest, 0.0]];
        }
        let slides: Vec<bool> =
            used.iter().zip(&beyond).map(|(used, slip)| *used && slip * kt > PRESLIDING_LENGTHS * fc).collect();
        let enough = slides.iter().filter(|slides| **slides).count() >= MIN_SLIDING_SAMPLES;
        let sliding = if enough && model == Model::Lugre { &slides } else { used };
        let of = |part: f64| {
            let vs = part * fastest;
            [steady(log, &friction, sliding, vs, fc, fastest), [0.8 * fc, 0.3 * fc, vs, 0.1 * fc / fastest]]
        };
        STRIBECK_REL.into_iter().flat_map(of).collect()
    };
    let first = friction.first().copied().unwrap_or(0.0);
    let one = |kt: f64, [coulomb, excess, vs, viscous]: [f64; 4]| -> Vec<f64> {
        let value = |name: &str| match name {
            "coulomb_n" => coulomb,
            "static_excess_n" => excess,
            "stribeck_m_per_s" => vs,
            "sigma2" => viscous,
            "stiffness_n_per_m" => kt,
            "initial_force_n" => first,
            "offset_n" => offset,
            _ => 0.0,
        };
        model.parameters(baseline).iter().map(|(name, log)| if *log { libm::log(value(name)) } else { value(name) }).collect()
    };
    stiffness
        .into_iter()
        .flat_map(|kt| steady_values(kt).into_iter().map(move |values| (kt, values)))
        .map(|(kt, values)| one(kt, values))
        .collect()
}

/// Returns the slip of each sample since the last reversal, m.
fn since_reversal(log: &Log) -> Vec<f64> {
    let mut sum = 0.0_f64;
    let of = |slip: &f64| {
        sum = if sum * slip < 0.0 { *slip } else { sum + slip };
        sum.abs()
    };
    log.slip_m.iter().map(of).collect()
}

/// Returns Coulomb force, static excess, Stribeck velocity and viscous friction for a given
/// Stribeck velocity. Without springs the rest is linear,
/// `F sgn V = Fc + dF exp(-(V / Vs)^2) + s2 |V|`. Values too small for a logarithm are replaced by
/// a small fraction of the friction.
fn steady(log: &Log, friction: &[f64], used: &[bool], vs: f64, fc: f64, fastest: f64) -> [f64; 4] {
    let samples = friction.iter().zip(&log.velocity_m_per_s).zip(used);
    let (mut matrix, mut right) = (nalgebra::Matrix3::zeros(), nalgebra::Vector3::zeros());
    for ((force, v), _) in samples.filter(|((_, v), used)| **used && **v != 0.0) {
        // Relative to the highest velocity, so that the columns have similar magnitudes.
        let row = nalgebra::Vector3::new(1.0, libm::exp(-(v / vs) * (v / vs)), v.abs() / fastest);
        matrix += row * row.transpose();
        right += row * (force * v.signum());
    }
    let found = matrix.lu().solve(&right).unwrap_or_else(|| nalgebra::Vector3::new(fc, 0.2 * fc, 0.01 * fc));
    let least = |value: f64, least: f64| if value.is_finite() { value.max(least * fc) } else { least * fc };
    [least(found[0], 0.05), least(found[1], 0.02), vs, least(found[2], 1e-3) / fastest]
}
