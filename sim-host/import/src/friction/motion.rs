//! Motion between the samples of a log, in steps of one direction and nearly one velocity.
//!
//! ```text
//! x(u) = d u + (v1 - v0) dt (u^2 - u) / 2,   0 <= u <= 1
//! ```
//!
//! The velocity is linear between two samples, and the slip `d` is that of the displacement. The
//! steps end at the samples, at reversals, and at equal changes of the velocity. They do not depend
//! on the parameters of a model, so that its residuals are smooth in them.

use super::log::Log;

/// Maximum number of steps of equal velocity change between two samples.
const MAX_STEPS: f64 = 32.0;
/// Minimum number of samples in each direction for an offset of the force.
const MIN_DIRECTION_SAMPLES: usize = 5;
/// Minimum number of reversals for a drift of the force.
const MIN_REVERSALS: usize = 4;

/// Part of the motion between two samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Slip, m.
    pub(super) slip_m: f64,
    /// Slip velocity at the end of the step, m/s.
    pub(super) velocity_m_per_s: f64,
    /// Normal force at the end of the step, relative to the mean.
    pub(super) normal_rel: f64,
    /// `true` if the step ends at a sample.
    pub(super) is_sample: bool,
}

/// Motion of a whole log.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    /// All steps; the first has no slip and ends at the first sample.
    pub(super) steps: Vec<Step>,
    /// Slip velocity of each sample, m/s.
    pub(super) velocity_m_per_s: Vec<f64>,
    /// Columns of the baseline of the force, for each sample: offset and drift, or fewer.
    pub(super) baseline: Vec<Vec<f64>>,
}

impl Motion {
    /// Divides the motion of a log into steps in which the velocity changes by at most
    /// `velocity_step`, m/s. `baseline` is the number of columns of the baseline.
    pub(super) fn new(log: &Log, velocity_step: f64, baseline: usize) -> Self {
        let (v, count) = (&log.velocity_m_per_s, log.slip_m.len());
        let normal = |at: usize| log.normals_n.get(at).map_or(1.0, |normal| normal / log.normal_n);
        // Without times, the mean interval follows from the slip and the velocity.
        let size = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>().max(f64::MIN_POSITIVE);
        let mean_s = size(&log.slip_m) / size(v);
        let interval = |at: usize| if log.time_s.is_empty() { mean_s } else { log.time_s[at] - log.time_s[at - 1] };
        let mut steps = Vec::with_capacity(count + count / 8);
        steps.push(Step { slip_m: 0.0, velocity_m_per_s: v[0], normal_rel: normal(0), is_sample: true });
        for at in 1..count {
            let (d, v0, rise) = (log.slip_m[at], v[at - 1], v[at] - v[at - 1]);
            let (n0, more) = (normal(at - 1), normal(at) - normal(at - 1));
            // Noise must not make a reversal between two velocities of one direction.
            let bend =
                if v0 * v[at] < 0.0 { rise * interval(at) } else { (rise * interval(at)).clamp(-2.0 * d.abs(), 2.0 * d.abs()) };
            let reversal = 0.5 - d / bend;
            let pieces = (rise.abs() / velocity_step).ceil().clamp(1.0, MAX_STEPS);
            let (mut u, mut x, mut next) = (0.0, 0.0, 1.0);
            while u < 1.0 {
                let is_reversal = reversal > u && reversal < next / pieces;
                let end = if is_reversal { reversal } else { next / pieces };
                next += f64::from(u8::from(!is_reversal));
                let to = d * end + 0.5 * bend * (end * end - end);
                let is_sample = end >= 1.0;
                steps.push(Step { slip_m: to - x, velocity_m_per_s: v0 + rise * end, normal_rel: n0 + more * end, is_sample });
                (u, x) = (end, to);
            }
        }
        let columns = [vec![1.0; count], (0..count).map(|at| drift(at, count)).collect()];
        Motion { steps, velocity_m_per_s: v.clone(), baseline: columns.into_iter().take(baseline).collect() }
    }
}

impl Motion {
    /// Returns `true` for each sample without a reversal before the next or after the last sample.
    pub(super) fn is_steady(&self) -> Vec<bool> {
        let mut steady = vec![true; self.velocity_m_per_s.len()];
        let (mut at, mut sign) = (0, 0.0);
        for step in &self.steps {
            if step.slip_m * sign < 0.0 {
                steady[at.max(1) - 1] = false;
                steady[at] = false;
            }
            sign = if step.slip_m == 0.0 { sign } else { step.slip_m };
            at += usize::from(step.is_sample);
        }
        steady
    }
}

/// Returns the part of the drift over a whole log that a sample has, from -1/2 to 1/2.
pub(crate) fn drift(at: usize, count: usize) -> f64 {
    at as f64 / (count.max(2) - 1) as f64 - 0.5
}

/// Returns the number of columns of a baseline of the force that the log determines: offset and
/// drift, or fewer. Sliding in one direction does not show an offset, and few reversals no drift.
pub(super) fn baseline(log: &Log) -> usize {
    let moving = || log.slip_m.iter().zip(&log.on).filter(|(slip, on)| **slip != 0.0 && !**on).map(|(slip, _)| *slip > 0.0);
    let (forward, all) = (moving().filter(|forward| *forward).count(), moving().count());
    let reversals = moving().zip(moving().skip(1)).filter(|(before, now)| before != now).count();
    match forward.min(all - forward) {
        ..MIN_DIRECTION_SAMPLES => 0,
        _ if reversals < MIN_REVERSALS => 1,
        _ => 2,
    }
}
