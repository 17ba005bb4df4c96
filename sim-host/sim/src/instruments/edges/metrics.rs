//! Metrics of the edges of bursts, from the envelope of the true tip velocity, accurate to a
//! fraction of a period: see [`edge_meter`](crate::edge_meter).

use firmware::seam::mode::Mode;

use crate::edge_meter::Edges;
use crate::instruments::View;
use crate::metrics::Metrics;
use crate::record::Row;
use report::statistics::mean;

/// Envelope at the end of the ring-up, relative to the steady one.
const RISEN_REL: f64 = 0.95;
/// Envelope at the end of the ring-down, relative to the steady one.
const FALLEN_REL: f64 = 0.05;
/// Number of samples by which amplifier, hold and delay outlast the codes.
const TAIL_SAMPLES: usize = 4;

/// Adds the metrics of the edges, and of the tip velocity between them.
pub(super) fn add(run: &View, metrics: &mut Metrics) {
    let tip = |row: &Row| row.truth.tip_velocity_m_per_s;
    let Some(steady) = mean(run.steady().map(tip)) else { return };
    let edges = &run.record.edges;
    let at_edges = edges.iter().flat_map(|edges| &edges.rising).copied().fold(0.0, f64::max);
    let peak_from = |from_s: f64| {
        run.rows.iter().filter(|row| row.mode == Mode::Run && row.time_s > from_s).map(tip).fold(at_edges, f64::max)
    };
    metrics.put("tip_velocity_m_per_s", steady);
    metrics.put("peak_velocity_m_per_s", peak_from(f64::NEG_INFINITY));
    // With several friction set points, the recorded bursts have other amplitudes than the last
    // one.
    if run.scene.controller.friction.is_some() {
        return;
    }
    worst_edges(run, steady, metrics);
    let first_s = edges.iter().filter_map(|edges| edges.first_s).reduce(f64::min).filter(|_| run.disturbed_s.is_empty());
    metrics.put("overshoot_percent", first_s.map(|first_s| 100.0 * (peak_from(first_s) / steady - 1.0).max(0.0)));
}

/// Adds the worst of all recorded bursts.
fn worst_edges(run: &View, steady: f64, metrics: &mut Metrics) {
    let (edges, sample_s) = (&run.record.edges, run.record.sample_s);
    let worst = |of: &dyn Fn(&Edges) -> Option<f64>| edges.iter().filter_map(of).reduce(f64::max);
    let rise = |edges: &Edges| reaches(&edges.rising, |v| v >= RISEN_REL * steady).map(|samples| samples * sample_s);
    let fall = |edges: &Edges| reaches(&edges.falling, |v| v <= FALLEN_REL * steady).map(|samples| samples * sample_s);
    // After an end without a brake or a ramp, the remaining vibration is not a residue.
    let residual = |edges: &Edges| {
        let left = edges
            .falling
            .get(edges.samples_to_silence + TAIL_SAMPLES..)
            .filter(|_| edges.samples_to_silence > 0)?
            .iter()
            .copied()
            .reduce(f64::max)?;
        Some(100.0 * left / steady)
    };
    metrics.put("rise_time_ms", worst(&rise).map(|s| 1e3 * s));
    metrics.put("fall_time_ms", worst(&fall).map(|s| 1e3 * s));
    metrics.put("residual_percent", worst(&residual));
}

/// Returns the number of samples after which an envelope first meets a condition, interpolated;
/// `None` if it does so from the beginning, which is not an edge.
fn reaches(envelope: &[f64], there: impl Fn(f64) -> bool) -> Option<f64> {
    let after = envelope.iter().position(|&v| there(v))?;
    let now = envelope[after];
    let before = envelope.get(after.checked_sub(1)?)?;
    // Found by bisection, because only the condition is known, not its level.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..20 {
        let part = 0.5 * (low + high);
        if there(before + part * (now - before)) { high = part } else { low = part }
    }
    Some(after as f64 + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn level_crossing_is_interpolated_between_samples() {
        let rising: Vec<f64> = (1..100).map(|n| 1.0 - (-0.05 * f64::from(n)).exp()).collect();
        let got = reaches(&rising, |v| v >= 0.95).unwrap();
        // ln(20) / 0.05 = 59.9146; linear interpolation between two samples gives 59.9147.
        assert!((got - 59.9146).abs() < 2e-2, "{got}");
        assert_eq!(reaches(&rising, |v| v > 1.0), None);
    }
}
