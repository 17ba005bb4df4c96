//! Generalised Maxwell slip model: springs in parallel, each of which slides beyond its own
//! deflection.
//!
//! The deflections are fixed, in logarithmic steps over the range that the log resolves. The
//! friction is then linear in the stiffnesses, which are fitted by non-negative least squares. V.
//! Lampaert, F. Al-Bender, J. Swevers, Proc. Int. Conf. Physics and Control (2003) 1188.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::log::Log;
use super::motion::Motion;
use report::statistics::{ascending, quantile};

/// Maximum number of slips of which the median is the resolution.
const MAX_SLIPS: usize = 20_000;
/// Number of springs of the model.
const SPRINGS: usize = 8;

/// Fitted Maxwell slip model.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Maxwell {
    /// Deflection at which each spring begins to slide, m.
    pub(super) deflections_m: Vec<f64>,
    /// Stiffness of each spring, N/m.
    pub(super) stiffnesses: Vec<f64>,
    /// Variances of the stiffnesses, for residuals of variance one; zero for stiffnesses that are
    /// zero.
    pub(super) variances: Vec<f64>,
    /// Friction at every sample, N.
    pub(super) force_n: Vec<f64>,
}

/// Fits the friction of the samples that are `used`; `None` if the log resolves no deflection.
pub(super) fn fit(log: &Log, friction_n: &[f64], used: &[bool]) -> Option<Maxwell> {
    let motion = &Motion::new(log, f64::INFINITY, 0);
    // Steps around a reversal can be arbitrarily short. The median is the resolution of the log.
    let some = log.slip_m.iter().step_by(log.slip_m.len() / MAX_SLIPS + 1);
    let steps = ascending(some.map(|slip| slip.abs()).filter(|slip| *slip > 0.0));
    let least = quantile(&steps, 0.5).unwrap_or(f64::INFINITY);
    let mut at = 0.0_f64;
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    for slip in &log.slip_m {
        at += slip;
        (low, high) = (low.min(at), high.max(at));
    }
    let most = 0.25 * (high - low);
    if !(least.is_finite() && most > 2.0 * least) {
        return None;
    }
    let deflections_m: Vec<f64> =
        (0..SPRINGS).map(|n| least * libm::pow(most / least, n as f64 / (SPRINGS - 1) as f64)).collect();
    let columns: Vec<Vec<f64>> = deflections_m.iter().map(|deflection| stop(motion, *deflection)).collect();
    let picked = |values: &[f64]| -> Vec<f64> { values.iter().zip(used).filter(|(_, used)| **used).map(|(v, _)| *v).collect() };
    let force = picked(friction_n);
    let some: Vec<Vec<f64>> = if used.contains(&false) { columns.iter().map(|c| picked(c)).collect() } else { Vec::new() };
    let rows = if some.is_empty() { &columns } else { &some };
    let mut active: Vec<usize> = (0..SPRINGS).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let scale: Vec<f64> = rows.iter().map(|row| dot(row, row).sqrt().max(f64::MIN_POSITIVE)).collect();
    let product = |i: usize, j: usize| if i <= j { dot(&rows[i], &rows[j]) / scale[i] / scale[j] } else { 0.0 };
    let mut gram = DMatrix::from_fn(SPRINGS, SPRINGS, product);
    gram.fill_lower_triangle_with_upper_triangle();
    let right: Vec<f64> = rows.iter().zip(&scale).map(|(row, scale)| dot(row, &force) / scale).collect();
    loop {
        let n = active.len();
        if n == 0 {
            return None;
        }
        let of = |i: usize, j: usize| gram[(active[i], active[j])];
        let factor = Cholesky::new(DMatrix::from_fn(n, n, |i, j| of(i, j) + if i == j { 1e-10 } else { 0.0 }))?;
        let found = factor.solve(&DVector::from_fn(n, |i, _| right[active[i]]));
        // The most negative spring is removed first.
        let worst = (0..n).min_by(|a, b| found[*a].total_cmp(&found[*b])).filter(|worst| found[*worst] <= 0.0);
        if let Some(worst) = worst {
            active.remove(worst);
            continue;
        }
        let inverse = factor.inverse();
        let (mut stiffnesses, mut variances) = (vec![0.0; SPRINGS], vec![0.0; SPRINGS]);
        for (i, spring) in active.iter().enumerate() {
            stiffnesses[*spring] = found[i] / scale[*spring];
            variances[*spring] = inverse[(i, i)] / (scale[*spring] * scale[*spring]);
        }
        let sample = |at: usize| stiffnesses.iter().zip(&columns).map(|(k, column)| k * column[at]).sum();
        let force_n = (0..log.slip_m.len()).map(sample).collect();
        return Some(Maxwell { deflections_m, stiffnesses, variances, force_n });
    }
}

/// Returns the deflection of a spring that slides beyond `limit`, at every sample, m. The limit is
/// proportional to the normal force.
fn stop(motion: &Motion, limit: f64) -> Vec<f64> {
    let mut deflection = 0.0_f64;
    let mut column = Vec::with_capacity(motion.count);
    for step in &motion.steps {
        let limit = limit * step.normal_rel;
        deflection = (deflection + step.slip_m).max(-limit).min(limit);
        if step.is_sample {
            column.push(deflection);
        }
    }
    column
}
