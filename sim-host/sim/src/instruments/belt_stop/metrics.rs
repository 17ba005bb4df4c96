//! Metrics of a belt that stops: time under drive after the stop, and the energy into the belt.

use crate::instruments::View;
use crate::metrics::Metrics;
use crate::record::Row;
use scene::FaultKind;

/// Tip velocity at which the tip has rung down, relative to that at the mute.
const RUNG_DOWN_REL: f64 = 0.05;
/// Length of belt over which the energy is counted, m.
const STRETCH_M: f64 = 1e-3;

impl View<'_> {
    pub(super) fn belt_stop(&self, metrics: &mut Metrics) {
        let (Some(counts_per_mm), Some(_)) = (self.scene.sensors.encoder_counts_per_mm, self.scene.sliding()) else { return };
        metrics.put("exposure_j_per_mm", self.exposure_j_per_mm());
        let slowest = 1.0 / (1e3 * counts_per_mm * 1e-3 * self.scene.controller.limits.belt_stop_ms);
        let Some(stop_s) = self.stop_s(slowest) else { return };
        let Some(muted) = self.muted_after(stop_s) else { return };
        let muted_s = self.rows[muted].time_s - self.block_s;
        metrics.put("belt_stop_to_mute_ms", 1e3 * (muted_s - stop_s));
        let tip = |row: &Row| row.truth.tip_velocity_m_per_s;
        let rings = self.rows[..muted].last().map_or(0.0, tip);
        let quiet = self.rows[muted..].iter().find(|row| tip(row) <= RUNG_DOWN_REL * rings);
        metrics.put("ring_down_ms", quiet.map(|row| 1e3 * (row.time_s - muted_s)));
    }

    /// Returns the time at which the belt becomes slower than `slowest`, or its encoder fails, s.
    fn stop_s(&self, slowest: f64) -> Option<f64> {
        let fails = |kind| matches!(kind, FaultKind::EncoderStuck | FaultKind::EncoderLost);
        let failure = self.scene.fault.iter().filter(|fault| fails(fault.kind)).map(|fault| fault.at_s).reduce(f64::min);
        let slow = self.rows.iter().find(|row| row.truth.belt_speed_m_per_s < slowest).map(|row| row.time_s - self.block_s);
        failure.into_iter().chain(slow).reduce(f64::min)
    }

    /// Returns the first row without drive after a time, if the drive was on at that time.
    fn muted_after(&self, time_s: f64) -> Option<usize> {
        let at = self.rows.partition_point(|row| row.time_s - self.block_s < time_s - 0.5 * self.block_s);
        let driven = at > 0 && self.rows[at - 1].drive_v > 0.0;
        let silent = self.rows[at..].iter().position(|row| row.drive_v == 0.0).filter(|_| driven)?;
        Some(at + silent)
    }

    fn exposure_j_per_mm(&self) -> f64 {
        let (mut stretch, mut energy_j, mut largest_j) = (None, 0.0, 0.0f64);
        for row in self.rows {
            let here = (row.truth.belt_position_m / STRETCH_M).floor();
            if stretch != Some(here) {
                (stretch, energy_j) = (Some(here), 0.0);
            }
            energy_j += row.truth.power_w * self.block_s;
            largest_j = largest_j.max(energy_j);
        }
        largest_j / (1e3 * STRETCH_M)
    }
}
