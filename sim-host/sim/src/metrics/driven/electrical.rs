//! What was driven, what it cost, and how the tip moved, by root mean square and peak: numbers that hold for any waveform, where an
//! amplitude is a sine's only. All are over the steady blocks, as the friction is; those of the drive are of the first lane, and those of
//! the tip of a stack's only.
//!
//! The power into the terminals is that into the motional branch and that into the clamped capacitance, which gives back over a
//! period what it took: its mean is the motional branch's.

use super::super::Metrics;
use super::View;
use crate::record::Row;

/// Adds these numbers; none where there is no steady block.
pub(super) fn add(view: &View, metrics: &mut Metrics) {
    let rows: Vec<&Row> = view.steady().collect();
    if rows.is_empty() {
        return;
    }
    let mean = |value: &dyn Fn(&Row) -> f64| rows.iter().map(|row| value(row)).sum::<f64>() / rows.len() as f64;
    let largest = |value: &dyn Fn(&Row) -> f64| rows.iter().map(|row| value(row)).fold(0.0, f64::max);
    metrics.put("drive_peak_v", largest(&|row| row.swing.peak_v));
    metrics.put("drive_rms_v", mean(&|row| row.swing.square_v2).sqrt());
    metrics.put("input_power_w", mean(&|row| row.truth.power_w));
    if rows.iter().all(|row| row.truth.tip.is_some()) {
        let tip = |row: &Row| row.truth.tip.unwrap_or_default();
        metrics.put("tip_velocity_rms_m_per_s", mean(&|row| tip(row).square_m2_per_s2).sqrt());
        metrics.put("tip_velocity_peak_m_per_s", largest(&|row| tip(row).peak_m_per_s));
    }
}
