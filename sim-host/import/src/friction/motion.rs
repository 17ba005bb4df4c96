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
/// Maximum number of such steps of a log with a mean of several between two samples.
const MAX_ALL_STEPS: f64 = 4e6;
/// Minimum travel in each direction for an offset of the force, relative to the whole.
const MIN_TRAVEL_REL: f64 = 0.05;
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
    /// Number of samples.
    pub(super) count: usize,
    /// Number of parameters of the baseline of the force: offset and drift, or fewer.
    pub(super) baseline: usize,
}

impl Motion {
    /// Divides the motion of a log into steps in which the velocity changes by at most
    /// `velocity_step`, m/s. `baseline` is the number of parameters of the baseline.
    pub(super) fn new(log: &Log, velocity_step: f64, baseline: usize) -> Self {
        let (v, count) = (&log.velocity_m_per_s, log.slip_m.len());
        let normal = |at: usize| log.normals_n.get(at).map_or(1.0, |normal| normal / log.normal_n);
        // Without times, the mean interval follows from the slip and the velocity.
        let size = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>().max(f64::MIN_POSITIVE);
        let mean_s = size(&log.slip_m) / size(v);
        let interval = |at: usize| if log.time_s.is_empty() { mean_s } else { log.time_s[at] - log.time_s[at - 1] };
        let most = MAX_STEPS.min(MAX_ALL_STEPS / count as f64).max(1.0);
        let mut steps = Vec::with_capacity(count + count / 8);
        steps.push(Step { slip_m: 0.0, velocity_m_per_s: v[0], normal_rel: normal(0), is_sample: true });
        for at in 1..count {
            let (d, v0, rise) = (log.slip_m[at], v[at - 1], v[at] - v[at - 1]);
            let (n0, more) = (normal(at - 1), normal(at) - normal(at - 1));
            // Noise must not make a reversal between two velocities of one direction.
            let bend =
                if v0 * v[at] < 0.0 { rise * interval(at) } else { (rise * interval(at)).clamp(-2.0 * d.abs(), 2.0 * d.abs()) };
            let reversal = 0.5 - d / bend;
            let pieces = (rise.abs() / velocity_step).ceil().clamp(1.0, most);
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
        Motion { steps, count, baseline }
    }
}

impl Motion {
    /// Returns `true` for each sample without a reversal before the next or after the last sample.
    pub(super) fn is_steady(&self) -> Vec<bool> {
        let mut steady = vec![true; self.count];
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

/// Returns the number of parameters of the baseline that the log determines: offset and drift, or
/// fewer. Sliding in one direction does not show an offset, and few reversals no drift.
pub(super) fn baseline(log: &Log) -> usize {
    let (mut travel, mut reversals, mut last) = ([0.0; 2], 0, 0.0);
    for slip in log.slip_m.iter().zip(&log.on).filter(|(slip, on)| **slip != 0.0 && !**on).map(|(slip, _)| *slip) {
        travel[usize::from(slip > 0.0)] += slip.abs();
        reversals += usize::from(slip * last < 0.0);
        last = slip;
    }
    match travel[0].min(travel[1]) < MIN_TRAVEL_REL * (travel[0] + travel[1]) {
        true => 0,
        false if reversals < MIN_REVERSALS => 1,
        false => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_at_reversals_and_add_up_to_the_slip() {
        let log = Log {
            slip_m: vec![0.0, 0.0, 4e-3, 1e-3],
            velocity_m_per_s: vec![2.0, -2.0, 6.0, 1e-3],
            time_s: vec![0.0, 1e-3, 2e-3, 3e-3],
            on: vec![false; 4],
            ..Log::default()
        };
        let motion = Motion::new(&log, 1.0, 0);
        // From 2 to -2 m/s in 1 ms: 0.5 mm forth and 0.5 mm back.
        let slips: Vec<f64> = motion.steps.iter().map(|step| step.slip_m).collect();
        let expected = [0.0, 3.75e-4, 1.25e-4, -1.25e-4, -3.75e-4];
        assert!(slips.iter().zip(expected).all(|(slip, expected)| (slip - expected).abs() < 1e-12), "{slips:?}");
        assert!((slips.iter().sum::<f64>() - 5e-3).abs() < 1e-12, "{slips:?}");
        assert_eq!(motion.is_steady(), [false, false, false, true]);
        assert_eq!(baseline(&log), 0);
    }
}
